"""The Co-Simulation FMUs of each version of FMI: how they are instantiated, initialised and stepped."""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any, Final

from typing_extensions import override

from fmus.toolchain.fmpy_library import (
    FMICallException,
    calloc,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2LastSuccessfulTime,
    fmi2Terminated,
    fmi3Error,
    free,
)
from fmus.toolchain.last_call import name_of, note
from fmus.units.fmi2_logger import formatting_logger, register, release
from fmus.units.fmi_api import FMI2_API, FMI3_API
from fmus.units.fmu_unit import FmuUnit
from fmus.units.prepared_calls import StepCall, direct_step
from fmus.units.unit import EndRequested, ExperimentSetup, UnitError, carry_out, is_failure
from fmus.units.value_calls import ADDRESS, library_function

_DISCARD: Final = 2
"""The FMI status of a step that was not made to its end."""
_SAME_TIME: Final = 1e-9
_NOT_WRITTEN: Final = -1.7e308
"""[s] The time that a step has reached before an FMU says which; some never do."""


def _is_within(t: float, reached: float, end: float) -> bool:
    """Whether a step from `t` to `end` [s] can have reached that time, which may be no number."""
    tolerance = _SAME_TIME * max(1.0, abs(end))
    return t - tolerance <= reached <= end + tolerance


class CoSimulationUnit(FmuUnit):
    """What the Co-Simulation units of all versions share: a first step that fails without the stop time."""

    _do_step: Any = None
    """The library's function for a step; None where an integrator makes the steps."""

    def _stepped(self, status: int, t: float, h: float) -> object:
        """The status of a step, which is made once more where the FMU wants to know the stop time."""
        if not is_failure(status) or t != self._setup.start or self._stop_is_told or self._setup.stop is None:
            return self._failed_step(status)
        try:
            self._tell_stop(UnitError(self.name, "the first step failed", self.messages))
            carry_out(self._setters)
            self.exit_initialization()
        except UnitError:
            return self._failed_step(status)
        carry_out(self._setters)
        return self.step(t, h)

    def _failed_step(self, status: int) -> int:
        """The status of a step that has failed; calls that followed it are not to blame."""
        self._failed_in = name_of(self._do_step)
        note(self._failed_in)
        return status


class Fmu2Unit(CoSimulationUnit):
    """An FMI 2.0 Co-Simulation FMU."""

    api = FMI2_API

    @override
    def _instantiate(self, *, logging: bool) -> None:
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = formatting_logger()
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        environment = register(self.name, self._log)
        self._resources.callback(release, environment)
        callbacks.componentEnvironment = environment
        self._fmu.instantiate(callbacks=callbacks, loggingOn=logging)

    @override
    def _enter(self, parameters: Mapping[str, Any], setup: ExperimentSetup) -> None:
        failed = "the initialization failed"
        # before the parameters: some FMUs load their own start values in this call
        self._check(failed, self._fmu.setupExperiment, setup.tolerance, setup.start, setup.stop)
        self._set_parameters(parameters)
        self._check(failed, self._fmu.enterInitializationMode)

    @override
    def _prepare_step(self) -> None:
        arguments = [ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_int]
        self._do_step = library_function(self._fmu, self.api, "DoStep", arguments)

    @override
    def step(self, t: float, h: float) -> object:
        status = self._do_step(self._component, t, h, 1)
        return self._outcome(status, t, h) if status else status

    @property
    @override
    def step_call(self) -> StepCall | None:
        return direct_step(self._do_step, self._component, (), self._outcome)

    def _outcome(self, status: int, t: float, h: float) -> object:
        """What a step from `t` of the length `h` [s] comes to that did not return `OK`."""
        if not is_failure(status):
            return status
        if status == _DISCARD:
            self._raise_end(t, t + h)
        return self._stepped(status, t, h)

    def _raise_end(self, t: float, end: float) -> None:
        """Raise `EndRequested` if the FMU discarded the step from `t` to `end` [s] because its simulation is over."""
        try:
            if not self._fmu.getBooleanStatus(fmi2Terminated):
                return
            reached = float(self._fmu.getRealStatus(fmi2LastSuccessfulTime))
        except (FMICallException, AttributeError):  # not every FMU knows; without an answer it is an ordinary failure
            return
        if not _is_within(t, reached, end):
            where = f"in the step from {t:g} s to {end:g} s it asks for the end of the run at {reached:g} s"
            self.remark(f"{where}; {t:g} s is taken for it")
            reached = t
        raise EndRequested(self.name, reached)


class Fmu3Unit(CoSimulationUnit):
    """An FMI 3.0 Co-Simulation FMU, without Event Mode."""

    api = FMI3_API
    _results: tuple[int, ...] = ()
    """The addresses of what a step says beside its status."""

    @override
    def _instantiate(self, *, logging: bool) -> None:
        self._fmu.instantiate(loggingOn=logging, logMessage=self._logged)

    def _logged(self, _environment: Any, status: int, _category: bytes, message: bytes) -> None:
        self._log(status, message)

    @override
    def _enter(self, parameters: Mapping[str, Any], setup: ExperimentSetup) -> None:
        if set(self._archive.structural) & parameters.keys():
            self._check("Configuration Mode was refused", self._fmu.enterConfigurationMode)
            self._set_parameters(parameters, structural=True)
            self._check("the structural parameters were refused", self._fmu.exitConfigurationMode)
        self._set_parameters(parameters)
        times = setup.tolerance, setup.start, setup.stop
        self._check("the initialization failed", self._fmu.enterInitializationMode, *times)

    @override
    def _prepare_step(self) -> None:
        arguments = [ADDRESS, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *[ADDRESS] * 4]
        self._do_step = library_function(self._fmu, self.api, "DoStep", arguments)
        self._flags = ctypes.create_string_buffer(3)  # event needed, terminate, early return
        self._reached = ctypes.c_double(_NOT_WRITTEN)
        self._is_off = False
        first = ctypes.addressof(self._flags)
        self._results = (first, first + 1, first + 2, ctypes.addressof(self._reached))

    @override
    def step(self, t: float, h: float) -> object:
        return self._outcome(self._do_step(self._component, t, h, 1, *self._results), t, h)

    @property
    @override
    def step_call(self) -> StepCall | None:
        return direct_step(self._do_step, self._component, self._results, self._outcome)

    def _outcome(self, status: int, t: float, h: float) -> object:
        """What a step from `t` of the length `h` [s] comes to, after what the FMU says of it."""
        if status and is_failure(status):
            return self._stepped(status, t, h)
        if self._flags.raw != b"\0\0\0":
            return self._flagged(status, t, t + h)
        if self._reached.value != t + h:
            self._compare_reached(t, t + h)
        return status

    def _compare_reached(self, t: float, end: float) -> None:
        """Say that a step from `t` to `end` [s] ended elsewhere for the FMU, which did not return early."""
        reached = self._reached.value
        if reached != _NOT_WRITTEN and not abs(reached - end) <= _SAME_TIME * max(1.0, abs(end)):
            where = f"in the step from {t:g} s to {end:g} s it says that it has reached {reached:g} s"
            if not self._is_off:  # it may say so in every step
                self.remark(f"{where}; the step is taken as whole")
            self._is_off = True

    def _flagged(self, status: int, t: float, end: float) -> object:
        """The status of a step from `t` to `end` [s] after which the FMU asks for something. Raises `EndRequested`."""
        _, terminate, early = (bool(flag) for flag in self._flags.raw)
        reached, self._failed_in = self._reached.value, name_of(self._do_step)
        if early and reached != _NOT_WRITTEN and not _is_within(t, reached, end):
            where = f"in the step from {t:g} s to {end:g} s"
            self.messages.append(f"it returned early, and says that it has reached {reached:g} s {where}")
            return max(status, fmi3Error)
        if terminate:
            raise EndRequested(self.name, min(reached, end) if early else end)
        if early and reached < end - _SAME_TIME * max(1.0, abs(end)):
            self.messages.append(f"the FMU returned early, at {reached:g} s, which it was not allowed to")
            return max(status, fmi3Error)
        remark = "it asks for Event Mode, which was not promised to it; its events are left to itself"
        if remark not in self.remarks:
            self.remarks.append(remark)
        return status
