"""An FMU as a unit in this process: one foreign call per direction and type, on memory shared with the signal table.

FMPy loads the library and brings the unit through its life; the calls of every macro step go to the library's
functions directly, with integer addresses prepared once (several times faster than converting them on each call).
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from typing_extensions import override

from components.interfaces.problem import refuse
from components.interfaces.quantity import DTYPES, Type
from components.interfaces.record import Variable
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.library import loaded
from fmus.reading.unpack import unpack
from fmus.toolchain.fmpy_library import (
    FMICallException,
    FMU2Slave,
    FMU3Slave,
    calloc,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi3Error,
    free,
)
from fmus.toolchain.version import Version
from fmus.units.fmi2_logger import formatting_logger, register, release
from fmus.units.unit import Column, Operation, Unit, UnitError, by_type

_ADDRESS = ctypes.c_size_t

_FAILURES = frozenset({"logStatusDiscard", "logStatusError", "logStatusFatal"})
"""FMI 2.0's names for the categories of messages that say why a call failed"""

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


class FmuUnit(Unit):
    """What FMI 2.0 and FMI 3.0 Co-Simulation units share."""

    prefix: str

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive.interface)
        self._archive = archive
        self._kept: list[Any] = []  # arrays whose addresses the library is given
        self._setters: list[Operation] = []
        self._getters: list[Operation] = []
        self._resources = ExitStack()  # released in the opposite order, whether all of them were taken or not
        try:
            made = TemporaryDirectory(prefix="macrostep_", ignore_cleanup_errors=True)
            folder = Path(self._resources.enter_context(made)).resolve()
            unpack(archive.path, folder, str(archive.path), VALID_FMU)
            self._fmu = loaded(self._kind(), archive, folder, name)
            self._resources.callback(self._fmu.freeLibrary)
            self._make_instance()
            self._resources.callback(self._free_instance)
        except BaseException:
            self._resources.close()
            raise

    def _kind(self) -> Any:
        """FMPy's class for this FMU."""
        raise NotImplementedError

    def _instantiate(self) -> None:
        """Call FMPy's `instantiate`, which raises bare Exception."""
        raise NotImplementedError

    def _prepare_step(self) -> None:
        """Prepare the call of every step."""
        raise NotImplementedError

    def _make_instance(self) -> None:
        try:
            self._instantiate()
        except Exception as error:
            said = f" ({'; '.join(dict.fromkeys(self.messages))})" if self.messages else ", and does not say why"
            token = "token" if self.prefix == "fmi3" else "GUID"
            raise refuse(
                str(self._archive.path),
                f"a library that refuses to make an instance{said}",
                f"a library that takes the {token} `{self._archive.description.guid}` of its modelDescription.xml",
                "Export the FMU again.",
            ) from error
        self._component = self._address()

    def _address(self) -> int:
        return int(ctypes.cast(self._fmu.component, ctypes.c_void_p).value or 0)

    def _free_instance(self) -> None:
        getattr(self._fmu, f"{self.prefix}FreeInstance")(self._fmu.component)

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
        self._kept.clear()  # of the memory that it was bound to before
        self._setters = [self._mover("Set", vs, inputs[k]) for k, vs in by_type(self.interface.inputs).items()]
        self._getters = [self._mover("Get", vs, outputs[k]) for k, vs in by_type(self.interface.outputs).items()]

    def _function(self, name: str, arguments: list[Any]) -> Any:
        function = self._fmu.dll[f"{self.prefix}{name}"]  # indexing makes a private copy, whose types are ours
        function.argtypes, function.restype = arguments, ctypes.c_int
        return function

    def _mover(self, direction: str, variables: Sequence[Variable], column: Column) -> Operation:
        """One call that moves the values of all `variables`, which are of one type, to or from `column`."""
        kind = variables[0].quantity.type
        access, native = _NATIVE[self._archive.version][kind]
        references = np.array([ref for v in variables for ref in self._archive.references[v.name]], dtype=np.uint32)
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
        for variable in (*self.interface.parameters, *self.interface.initials):
            if variable.name in parameters and (variable.name in self._archive.structural) is structural:
                column = np.array(parameters[variable.name], dtype=DTYPES[variable.quantity.type]).ravel()
                if status := self._mover("Set", [variable], column)():
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
        self._resources.close()


class Fmu2Unit(FmuUnit):
    """An FMI 2.0 Co-Simulation FMU."""

    prefix = "fmi2"

    @override
    def _kind(self) -> Any:
        return FMU2Slave

    @override
    def _instantiate(self) -> None:
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = formatting_logger()
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        environment = register(self.name, self._log)
        self._resources.callback(release, environment)
        callbacks.componentEnvironment = environment
        try:
            self._fmu.instantiate(callbacks=callbacks, loggingOn=False)
        except Exception:  # noqa: BLE001 - once more, to hear why: many say it only when they are asked to log
            self._fmu.instantiate(callbacks=callbacks, loggingOn=True)
        wanted = [c.name for c in self._archive.description.logCategories if c.name in _FAILURES]
        if wanted:  # not all: a log of every event costs time at every step
            with suppress(FMICallException):
                self._fmu.setDebugLogging(loggingOn=True, categories=wanted)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        self._set_parameters(parameters)
        self._check("the initialization failed", self._fmu.setupExperiment)
        self._check("the initialization failed", self._fmu.enterInitializationMode)
        self._prepare_step()

    @override
    def _prepare_step(self) -> None:
        self._do_step = self._function("DoStep", [_ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_int])

    @override
    def step(self, t: float, h: float) -> object:
        return self._do_step(self._component, t, h, 1)


class Fmu3Unit(FmuUnit):
    """An FMI 3.0 Co-Simulation FMU, without event mode."""

    prefix = "fmi3"

    @override
    def _kind(self) -> Any:
        return FMU3Slave

    @override
    def _instantiate(self) -> None:
        self._fmu.instantiate(loggingOn=True, logMessage=self._logged)

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
        self._prepare_step()

    @override
    def _prepare_step(self) -> None:
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
            return max(int(status), fmi3Error)
        return status
