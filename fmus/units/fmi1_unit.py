"""FMUs of FMI 1.0: their life cycle led through the calls of the other versions.

FMI 1.0 has no Initialization Mode: parameters, start values and inputs are set first, and one call initialises the FMU.
It is made when an output is asked for, or when the initialisation ends, so that the inputs have been set before.
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from abc import abstractmethod
from collections.abc import Collection, Mapping
from typing import Any

from typing_extensions import override

from fmus.toolchain.fmpy_library import (
    FMICallException,
    calloc,
    fmi1CallbackAllocateMemoryTYPE,
    fmi1CallbackFreeMemoryTYPE,
    fmi1CallbackFunctions,
    free,
)
from fmus.units.co_simulation import CoSimulationUnit
from fmus.units.fmi2_logger import formatting_logger, register, release
from fmus.units.fmi_api import FMI1_API
from fmus.units.fmu_unit import FmuUnit
from fmus.units.unit import (
    DEFAULT_SETUP,
    FMI_WARNING,
    ExperimentSetup,
    Operation,
    TypedColumns,
    UnitError,
    carry_out,
    is_failure,
)
from fmus.units.value_calls import ADDRESS, library_function


class Fmi1Unit(FmuUnit):
    """What the units of FMI 1.0 share."""

    api = FMI1_API

    _is_initialized = False
    _told = DEFAULT_SETUP
    _values: list[Operation]

    @abstractmethod
    def _initialize(self) -> None:
        """Call FMI's function that initialises. Raises `UnitError`."""

    @override
    def _instantiate(self, *, logging: bool) -> None:
        callbacks = fmi1CallbackFunctions()
        callbacks.logger = formatting_logger()
        callbacks.allocateMemory = fmi1CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi1CallbackFreeMemoryTYPE(free)
        self._resources.callback(release, register(self.name, self._log))
        self._fmu.instantiate(functions=callbacks, loggingOn=logging)
        if not self._fmu.component:
            raise FMICallException("fmiInstantiate", FMI_WARNING)

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        super().bind(inputs, outputs, unset)
        self._values, self._getters = self._getters, [self._show_values]

    def _show_values(self) -> object:
        self._initialize_once()
        return carry_out(self._values)

    @override
    def _enter(self, parameters: Mapping[str, Any], setup: ExperimentSetup) -> None:
        self._told, self._is_initialized = setup, False
        self._set_parameters(parameters)

    def _initialize_once(self) -> None:
        """Initialise the FMU unless it is; once more with the stop time, where it fails without."""
        if self._is_initialized:
            return
        try:
            self._initialize()
        except UnitError as failure:
            self._tell_stop(failure)
            carry_out(self._setters)
            self._initialize()
        self._is_initialized = True

    @override
    def exit_initialization(self) -> None:
        self._initialize_once()


class Fmu1Unit(Fmi1Unit, CoSimulationUnit):
    """An FMI 1.0 Co-Simulation FMU."""

    @override
    def _initialize(self) -> None:
        # not by FMPy's method, which takes the status for the address of a text
        arguments = [ADDRESS, ctypes.c_double, ctypes.c_byte, ctypes.c_double]
        function = library_function(self._fmu, self.api, "InitializeSlave", arguments)
        stop = self._told.stop
        status = function(self._component, self._told.start, stop is not None, 0.0 if stop is None else stop)
        if is_failure(status):
            error = FMICallException("fmiInitializeSlave", status)
            raise UnitError(self.name, f"the initialization failed: {error}", self.messages)

    @override
    def _prepare_step(self) -> None:
        arguments = [ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_byte]
        self._do_step = library_function(self._fmu, self.api, "DoStep", arguments)

    @override
    def step(self, t: float, h: float) -> object:
        status = self._do_step(self._component, t, h, 1)
        return self._stepped(status, t, h) if is_failure(status) else status

    @override
    def _free_instance(self) -> None:
        self._fmu.fmi1FreeSlaveInstance(self._fmu.component)
