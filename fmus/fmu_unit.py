"""An FMU as a unit in this process: one foreign call per direction and type, on memory shared with the signal table.

FMPy loads the library and brings the unit through its life; the calls of every macro step go to the library's
functions directly, with integer addresses prepared once (`facts`: several times faster than converting on each call).
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import shutil
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import fmpy
import numpy as np
from fmpy import calloc, fmi2, fmi3, free
from fmpy.fmi1 import FMICallException
from typing_extensions import override

from components.interfaces.problem import refuse
from components.interfaces.quantity import DTYPES, Type
from fmus.archive import Archive
from fmus.unit import Column, Operation, Unit, UnitError, by_type
from fmus.version import Version

_ADDRESS = ctypes.c_size_t

_NATIVE: Mapping[Version, Mapping[Type, tuple[str, type[np.generic]]]] = {
    Version.FMI2: {
        Type.FLOAT64: ("Real", np.float64),
        Type.INT32: ("Integer", np.int32),
        Type.BOOLEAN: ("Boolean", np.int32),
        Type.ENUMERATION: ("Integer", np.int32),
        Type.STRING: ("String", np.object_),
    },
    Version.FMI3: {
        **{kind: (kind.value, dtype) for kind, dtype in DTYPES.items()},
        Type.ENUMERATION: ("Int64", np.int64),
    },
}
"""The access function of each type and how it stores a value."""


def fmu_unit(name: str, archive: Archive) -> FmuUnit:
    """The FMU in `archive` as a unit."""
    return (Fmu2Unit if archive.version == Version.FMI2 else Fmu3Unit)(name, archive)


class FmuUnit(Unit):
    """What FMI 2.0 and FMI 3.0 Co-Simulation units share."""

    prefix: str

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive.interface)
        self._archive = archive
        self._folder = tempfile.mkdtemp(prefix="macrostep_")
        fmpy.extract(str(archive.path), self._folder)
        self._fmu = self._instantiate()
        self._component = int(ctypes.cast(self._fmu.component, ctypes.c_void_p).value or 0)
        self._kept: list[Any] = []  # arrays whose addresses the library is given
        self._setters: list[Operation] = []
        self._getters: list[Operation] = []

    def _instantiate(self) -> Any:
        raise NotImplementedError

    def _loaded(self, kind: Any) -> Any:
        description = self._archive.description
        try:
            return kind(
                guid=description.instantiationToken if self.prefix == "fmi3" else description.guid,
                modelIdentifier=description.coSimulation.modelIdentifier,
                unzipDirectory=self._folder,
                instanceName=self.name,
            )
        except Exception as error:  # FMPy raises bare Exception
            shutil.rmtree(self._folder, ignore_errors=True)
            raise refuse(
                str(self._archive.path),
                f"a library that cannot be loaded ({error})",
                f"a binary for this platform ({fmpy.platform_tuple})",
                "Compile the FMU for this platform.",
            ) from error

    def _check(self, action: str, call: Callable[[], Any]) -> None:
        try:
            call()
        except FMICallException as error:
            raise UnitError(self.name, f"{action}: {error}", self.messages) from error

    def _log(self, status: int, message: bytes) -> None:
        if status > 0:
            self.messages.append(message.decode("utf-8", "replace"))

    @override
    def bind(self, inputs: Mapping[Type, Column], outputs: Mapping[Type, Column]) -> None:
        self._setters = [self._mover("Set", k, names, inputs[k]) for k, names in self._names(self.interface.inputs)]
        self._getters = [self._mover("Get", k, names, outputs[k]) for k, names in self._names(self.interface.outputs)]

    @staticmethod
    def _names(variables: Any) -> list[tuple[Type, list[str]]]:
        return [(kind, [v.name for v in group]) for kind, group in by_type(variables).items()]

    def _function(self, name: str, arguments: list[Any]) -> Any:
        function = self._fmu.dll[f"{self.prefix}{name}"]  # indexing makes a private copy, whose types are ours
        function.argtypes, function.restype = arguments, ctypes.c_int
        return function

    def _mover(self, direction: str, kind: Type, names: list[str], column: Column) -> Operation:
        """One call that moves the values of all `names`, which are of one type, to or from `column`."""
        access, native = _NATIVE[self._archive.version][kind]
        references = np.array([ref for n in names for ref in self._archive.references[n]], dtype=np.uint32)
        if not kind.is_number:
            return self._text_mover(direction, kind, references, column)
        shared = column.dtype == native and column.flags.c_contiguous
        values = column if shared else np.zeros(column.size, dtype=native)
        self._kept += [references, values]
        extra = [values.size] if self.prefix == "fmi3" else []
        function = self._function(f"{direction}{access}", [_ADDRESS] * (4 + len(extra)))
        call = partial(function, self._component, references.ctypes.data, references.size, values.ctypes.data, *extra)
        if shared:
            return call

        def converted_set() -> object:
            values[:] = column
            return call()

        def converted_get() -> object:
            status = call()
            column[:] = values
            return status

        return converted_set if direction == "Set" else converted_get

    def _text_mover(self, direction: str, kind: Type, references: Column, column: Column) -> Operation:
        """The same for String and Binary, whose values are copied one by one."""
        self._kept.append(references)
        n, binary = column.size, kind is Type.BINARY
        pointers = (ctypes.c_char_p * n)() if direction == "Set" else (ctypes.c_void_p * n)()
        sizes = (ctypes.c_size_t * n)()
        function = self._function(f"{direction}{kind.value}", [_ADDRESS] * (4 + binary + (self.prefix == "fmi3")))
        arguments = [self._component, references.ctypes.data, references.size]
        arguments += [ctypes.addressof(sizes)] * binary + [ctypes.addressof(pointers)] + [n] * (self.prefix == "fmi3")

        def set_values() -> object:
            data = column.tolist() if binary else [text.encode() for text in column.tolist()]
            pointers[:], sizes[:] = data, [len(item) for item in data]
            return function(*arguments)

        def get_values() -> object:
            status = function(*arguments)
            lengths = sizes if binary else [-1] * n
            found = [ctypes.string_at(p, size) if p else b"" for p, size in zip(pointers, lengths, strict=True)]
            column[:] = found if binary else [item.decode("utf-8", "replace") for item in found]
            return status

        return set_values if direction == "Set" else get_values

    def _set_parameters(self, parameters: Mapping[str, Any], *, structural: bool = False) -> None:
        for variable in self.interface.parameters:
            if variable.name in parameters and (variable.name in self._archive.structural) is structural:
                kind = variable.quantity.type
                column = np.array(parameters[variable.name], dtype=DTYPES[kind]).ravel()
                if status := self._mover("Set", kind, [variable.name], column)():
                    action = f"setting the parameter {variable.name} to {parameters[variable.name]} (status {status})"
                    raise UnitError(self.name, action, self.messages)

    @override
    def setters(self) -> list[Operation]:
        return self._setters

    @override
    def getters(self) -> list[Operation]:
        return self._getters

    def _of_state(self, verb: str) -> Callable[..., Any]:
        return getattr(self._fmu, f"{verb}{'FMUstate' if self.prefix == 'fmi2' else 'FMUState'}")

    @override
    def save(self) -> Any:
        found: list[Any] = []
        self._check("its state could not be saved", lambda: found.append(self._of_state("get")()))
        return found[0]

    @override
    def restore(self, state: Any) -> None:
        self._check("its state could not be restored", lambda: self._of_state("set")(state))

    @override
    def forget(self, state: Any) -> None:
        self._check("its state could not be released", lambda: self._of_state("free")(state))

    @override
    def exit_initialization(self) -> None:
        self._check("the initialization failed", self._fmu.exitInitializationMode)

    @override
    def close(self) -> None:
        if self._component:
            self._component = 0
            self._fmu.freeInstance()
            shutil.rmtree(self._folder, ignore_errors=True)


class Fmu2Unit(FmuUnit):
    """An FMI 2.0 Co-Simulation FMU."""

    prefix = "fmi2"

    def _instantiate(self) -> Any:
        fmu = self._loaded(fmi2.FMU2Slave)
        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._logged)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        try:
            fmu.instantiate(callbacks=callbacks)
        except Exception as error:  # FMPy raises bare Exception
            raise UnitError(self.name, f"could not be instantiated ({error})", self.messages) from error
        self._step = None
        return fmu

    def _logged(self, _environment: Any, _name: bytes, status: int, _category: bytes, message: bytes) -> None:
        self._log(status, message)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        self._set_parameters(parameters)
        self._check("the initialization failed", self._fmu.setupExperiment)
        self._check("the initialization failed", self._fmu.enterInitializationMode)
        self._do_step = self._function("DoStep", [_ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_int])

    @override
    def step(self, t: float, h: float) -> object:
        return self._do_step(self._component, t, h, 1)


class Fmu3Unit(FmuUnit):
    """An FMI 3.0 Co-Simulation FMU, without event mode."""

    prefix = "fmi3"

    def _instantiate(self) -> Any:
        fmu = self._loaded(fmi3.FMU3Slave)
        try:
            fmu.instantiate(loggingOn=True, logMessage=self._logged)
        except Exception as error:  # FMPy raises bare Exception
            raise UnitError(self.name, f"could not be instantiated ({error})", self.messages) from error
        return fmu

    def _logged(self, _environment: Any, status: int, _category: bytes, message: bytes) -> None:
        self._log(status, message)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        if set(self._archive.structural) & parameters.keys():
            self._check("Configuration Mode was refused", self._fmu.enterConfigurationMode)
            self._set_parameters(parameters, structural=True)
            self._check("the structural parameters were refused", self._fmu.exitConfigurationMode)
        self._set_parameters(parameters)
        self._check("the initialization failed", self._fmu.enterInitializationMode)
        arguments = [_ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *[_ADDRESS] * 4]
        self._do_step = self._function("DoStep", arguments)
        self._flags = ctypes.create_string_buffer(3)  # event needed, terminate, early return
        self._reached = ctypes.c_double()
        first = ctypes.addressof(self._flags)
        self._results = (first, first + 1, first + 2, ctypes.addressof(self._reached))

    @override
    def step(self, t: float, h: float) -> object:
        status = self._do_step(self._component, t, h, 1, *self._results)
        if self._flags.raw != b"\0\0\0":
            self.messages.append(f"the FMU asked for an event, the end or an early return at {self._reached.value:g} s")
            return max(int(status), int(Version.FMI3))
        return status
