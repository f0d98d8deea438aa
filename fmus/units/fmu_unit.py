"""Co-Simulation FMUs as units in this process: one foreign call per direction and type, on memory that is shared.

FMPy loads the library and leads the instance through its life cycle; the calls of every macro step go to the library's
functions directly (`fmus.units.value_calls`).
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from abc import abstractmethod
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from components.interfaces.problem import refuse
from components.interfaces.quantity import DTYPES
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.library import loaded
from fmus.reading.unpack import unpack
from fmus.toolchain.fmpy_library import (
    FMICallException,
    calloc,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi3Error,
    free,
)
from fmus.units.capabilities import StateCapability
from fmus.units.fmi2_logger import formatting_logger, register, release
from fmus.units.fmi_api import FMI2_API, FMI3_API, FmiApi
from fmus.units.unit import Operation, TypedColumns, Unit, UnitError
from fmus.units.value_calls import ADDRESS, ValueCalls, library_function

_FAILURES = frozenset({"logStatusDiscard", "logStatusError", "logStatusFatal"})
"""FMI 2.0's names for the categories of messages that say why a call failed."""


class FmuUnit(Unit):
    """What the units of both versions of FMI share: unpacking, life cycle, values and state.

    Args:
        name: Name of the unit, which is also that of the instance.
        archive: The FMU file.

    Raises:
        RequestError: The library cannot be loaded, or refuses to make an instance.
    """

    api: ClassVar[FmiApi]

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive.interface)
        self._archive = archive
        self._setters: list[Operation] = []
        self._getters: list[Operation] = []
        self._resources = ExitStack()  # released in the opposite order, whether all of them were taken or not
        try:
            temporary = TemporaryDirectory(prefix="macrostep_", ignore_cleanup_errors=True)
            folder = Path(self._resources.enter_context(temporary)).resolve()
            unpack(archive.path, folder, str(archive.path), VALID_FMU)
            self._fmu = loaded(self._fmpy_class(), archive, folder, name)
            self._resources.callback(self._fmu.freeLibrary)
            self._make_instance()
            self._resources.callback(self._free_instance)
        except BaseException:
            self._resources.close()
            raise
        if archive.interface.rolls_back:
            self.state = FmuState(self._fmu, self.api, self._check)

    def _fmpy_class(self) -> type[Any]:
        return self.api.co_simulation

    @abstractmethod
    def _instantiate(self) -> None:
        """Call FMPy's `instantiate`, which raises bare Exception."""

    @abstractmethod
    def _prepare_step(self) -> None:
        """Prepare the call of every step."""

    def _make_instance(self) -> None:
        try:
            self._instantiate()
        except Exception as error:
            reason = f" ({'; '.join(dict.fromkeys(self.messages))})" if self.messages else ", and does not say why"
            token = f"{self.api.token} `{self._archive.description.guid}`"
            raise refuse(
                str(self._archive.path),
                f"a library that refuses to make an instance{reason}",
                f"a library that takes the {token} of its modelDescription.xml",
                "Export the FMU again.",
            ) from error
        self._take_address()

    def _take_address(self) -> None:
        """Note the address of the instance for the calls that are made directly."""
        self._component = int(ctypes.cast(self._fmu.component, ctypes.c_void_p).value or 0)

    def _free_instance(self) -> None:
        getattr(self._fmu, f"{self.api.prefix}FreeInstance")(self._fmu.component)

    def _check(self, action: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a method of FMPy's object; `action` names the failure in the error. Raises `UnitError`."""
        try:
            return function(*arguments)
        except FMICallException as error:
            raise UnitError(self.name, f"{action}: {error}", self.messages) from error

    def _log(self, status: int, message: bytes) -> None:
        if status > 0:
            self.messages.append(message.decode("utf-8", "replace"))

    def _value_calls(self) -> ValueCalls:
        return ValueCalls(self._fmu, self.api, self._component, self._archive.references)

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns) -> None:
        self._calls = self._value_calls()  # the previous calls and what they keep alive are not needed any more
        self._setters = self._calls.movers("Set", self.interface.inputs, inputs)
        self._getters = self._calls.movers("Get", self.interface.outputs, outputs)

    def _set_parameters(self, parameters: Mapping[str, Any], *, structural: bool = False) -> None:
        calls = self._value_calls()
        for variable in (*self.interface.parameters, *self.interface.initials):
            if variable.name in parameters and (variable.name in self._archive.structural) is structural:
                column = np.array(parameters[variable.name], dtype=DTYPES[variable.quantity.type]).ravel()
                if status := calls.mover("Set", [variable], column)():
                    action = f"setting the parameter {variable.name} to {parameters[variable.name]} (status {status})"
                    raise UnitError(self.name, action, self.messages)

    @override
    def setters(self) -> list[Operation]:
        return self._setters

    @override
    def getters(self) -> list[Operation]:
        return self._getters

    @override
    def exit_initialization(self) -> None:
        self._check("the initialization failed", self._fmu.exitInitializationMode)

    @override
    def close(self) -> None:
        self._resources.close()


class FmuState(StateCapability):
    """The FMU state, which stays inside the FMU; a saved state is a pointer to it."""

    def __init__(self, fmu: Any, api: FmiApi, check: Callable[..., Any]) -> None:
        self._check = check
        self._get, self._set, self._free = (getattr(fmu, n) for n in (api.get_state, api.set_state, api.free_state))

    @override
    def save(self) -> Any:
        return self._check("its state could not be saved", self._get)

    @override
    def restore(self, state: Any) -> None:
        self._check("its state could not be restored", self._set, state)

    @override
    def forget(self, state: Any) -> None:
        self._check("its state could not be released", self._free, state)


class Fmu2Unit(FmuUnit):
    """An FMI 2.0 Co-Simulation FMU."""

    api = FMI2_API

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
        except Exception:  # noqa: BLE001 - a second attempt with logging, without which many give no reason
            self._fmu.instantiate(callbacks=callbacks, loggingOn=True)
        categories = [c.name for c in self._archive.description.logCategories if c.name in _FAILURES]
        if categories:  # only these, because a log of every event takes time in every step
            with suppress(FMICallException):
                self._fmu.setDebugLogging(loggingOn=True, categories=categories)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        self._set_parameters(parameters)
        self._check("the initialization failed", self._fmu.setupExperiment)
        self._check("the initialization failed", self._fmu.enterInitializationMode)
        self._prepare_step()

    @override
    def _prepare_step(self) -> None:
        arguments = [ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_int]
        self._do_step = library_function(self._fmu, self.api, "DoStep", arguments)

    @override
    def step(self, t: float, h: float) -> object:
        return self._do_step(self._component, t, h, 1)


class Fmu3Unit(FmuUnit):
    """An FMI 3.0 Co-Simulation FMU, without Event Mode."""

    api = FMI3_API

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
        arguments = [ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *[ADDRESS] * 4]
        self._do_step = library_function(self._fmu, self.api, "DoStep", arguments)
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
