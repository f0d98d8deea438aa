"""Model Exchange FMUs as units: integrated by CVODE from one communication point to the next, with all their events.

Inputs are held over a macro step and jump at communication points. An input that has changed is an event: it is set in
Event Mode, the discrete states are iterated, and the integrator is reset. State events (event indicators), time events
and step events (`completedIntegratorStep`) are handled alike. Outputs follow the inputs at one instant, without a step.
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Mapping
from typing import Any, Final

from typing_extensions import override

from fmus.reading.archive import Archive
from fmus.toolchain.fmpy_library import FMICallException
from fmus.units.co_simulation import Fmu2Unit, Fmu3Unit
from fmus.units.cvode_integrator import CvodeIntegrator, IntegrationError
from fmus.units.fmu_unit import FmuUnit
from fmus.units.unit import DEFAULT_SETUP, Column, EndRequested, ExperimentSetup, TypedColumns, UnitError, carry_out

RELATIVE_TOLERANCE: Final = 1e-8
"""The relative tolerance where the FMU declares none."""
LOOSEST_TOLERANCE: Final = 1e-6
"""The largest relative tolerance, whatever the FMU declares."""
MOST_EVENTS: Final = 1000
"""The most events in one macro step, and iterations of one event; one that needs more is assumed never to settle."""
_SAME_TIME: Final = 1e-12


class ModelExchangeUnit(FmuUnit):
    """What the Model Exchange units of all versions share; for the integrator, a unit is its `ContinuousModel`."""

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive)
        self._integrator: CvodeIntegrator | None = None
        self._resources.callback(self._close_integrator)
        self._time = 0.0
        self._next_event: float | None = None
        self._running = False
        self._unsettled = False
        self._inputs: list[Column] = []
        self._seen: list[Any] | None = None
        self.n_states = 0
        self.n_indicators = 0
        self._tolerance = RELATIVE_TOLERANCE

    @override
    def _prepare_step(self) -> None:
        """There is no call to prepare: the integrator makes the steps."""

    @override
    def _fmpy_class(self) -> type[Any]:
        return self.api.model_exchange

    @abstractmethod
    def _new_discrete_states(self) -> tuple[bool, bool, bool, bool, bool, float]:
        """Update the discrete states once, and return the results of FMI's function of this name."""

    @abstractmethod
    def get_derivatives(self, dx: Any, n: int) -> None:
        """Evaluate the derivatives of the continuous states."""

    @abstractmethod
    def _count(self) -> tuple[int, int]:
        """The numbers of continuous states and event indicators."""

    def get_states(self, x: Any, n: int) -> None:
        """Read the continuous states."""
        self._fmu.getContinuousStates(x, n)

    def set_states(self, x: Any, n: int) -> None:
        """Set the continuous states."""
        self._fmu.setContinuousStates(x, n)

    def get_indicators(self, z: Any, n: int) -> None:
        """Evaluate the event indicators."""
        if n:
            self._fmu.getEventIndicators(z, n)

    def get_nominals(self, x: Any, n: int) -> None:
        """Read the nominal values of the states."""
        self._fmu.getNominalsOfContinuousStates(x, n)

    def set_time(self, t: float) -> None:
        """Set the time."""
        self._fmu.setTime(t)

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        super().enter_initialization(parameters, setup)
        self._time, self._next_event, self._seen = self._setup.start, None, None
        self._running = self._unsettled = False
        self._tolerance = self._integration_tolerance(setup.tolerance)

    def _integration_tolerance(self, wanted: float | None) -> float:
        """The relative tolerance of the integrator: what a person wants, else at least as fine as our default."""
        declared = self._archive.suggested.tolerance or 0.0
        if wanted is None and declared > LOOSEST_TOLERANCE:
            finer = f"{LOOSEST_TOLERANCE:g}, a relative tolerance finer than the {declared:g} of its file"
            self.remarks.append(f"it is integrated with {finer}; --tolerance changes it")
        return wanted or (min(declared, LOOSEST_TOLERANCE) if declared > 0 else RELATIVE_TOLERANCE)

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        super().bind(inputs, outputs, unset)
        self._inputs = list(inputs.values())
        self._movers, self._readers = self._setters, self._getters
        self._setters = [self._take_inputs]
        self._getters = [self._show_outputs]

    def _take_inputs(self) -> object:
        """Set the inputs if any has changed: in Event Mode, as discrete ones may change nowhere else."""
        seen = [c.tolist() if c.dtype == object else c.tobytes() for c in self._inputs]
        if seen == self._seen:
            return 0
        self._seen = seen
        self._begin_event()
        return carry_out(self._movers)

    def _begin_event(self) -> None:
        """Enter Event Mode, where discrete inputs and parameters may be set; `_settle` ends what this begins."""
        if self._running and not self._unsettled:
            self._check("Event Mode was refused", self._fmu.enterEventMode)
            self._unsettled = True

    @override
    def tune(self, parameter: str, value: Any) -> None:
        self._begin_event()
        super().tune(parameter, value)

    def _show_outputs(self) -> object:
        self._settle()
        return carry_out(self._readers)

    @override
    def exit_initialization(self) -> None:
        super().exit_initialization()  # afterwards the FMU is in Event Mode
        self._check("the initialization failed", self._begin)
        carry_out(self._readers)  # the initial event may have changed what they showed before

    def _begin(self) -> None:
        self._iterate()
        self._fmu.enterContinuousTimeMode()
        self.n_states, self.n_indicators = self._count()
        self._close_integrator()
        self._integrator = CvodeIntegrator(self, self._time, self._tolerance)
        self._running = True

    def _close_integrator(self) -> None:
        if self._integrator is not None:
            self._integrator.close()
            self._integrator = None

    def _settle(self) -> None:
        """End the event that changed inputs have begun."""
        if self._unsettled:
            self._unsettled = False
            self._check("an event failed", self._end_event)

    def _end_event(self) -> None:
        self._iterate()
        self._fmu.enterContinuousTimeMode()
        if self._integrator is not None:
            self._integrator.reset(self._time)

    def _iterate(self) -> None:
        """Iterate the discrete states until they no longer change."""
        for _ in range(MOST_EVENTS):
            again, terminate, _nominals, _values, defined, following = self._new_discrete_states()
            if terminate:
                raise EndRequested(self.name, self._time)
            if not again:
                self._next_event = following if defined else None
                return
        action = f"the event at {self._time:g} s does not settle in {MOST_EVENTS} iterations"
        raise UnitError(self.name, action, self.messages)

    @override
    def step(self, t: float, h: float) -> object:
        self._settle()
        try:
            self._integrate(t + h)
        except FMICallException as error:
            self.messages.append(str(error))
            return error.status
        except IntegrationError as error:
            raise UnitError(self.name, str(error), self.messages) from error
        return 0

    def _integrate(self, target: float) -> None:
        assert self._integrator is not None  # noqa: S101 - made when the initialisation ended
        events, began = 0, self._time
        while self._before(target) or self._is_due():
            root = False
            if not self._is_due():
                following = target if self._next_event is None else min(target, self._next_event)
                self._time, root = self._integrator.advance(following)
            step_event = self._completed_step()
            if root or step_event or self._is_due():
                events += 1
                if events > MOST_EVENTS:
                    action = f"more than {MOST_EVENTS} events from {began:g} s to {self._time:g} s: they may never end"
                    raise UnitError(self.name, action, self.messages)
                self._fmu.enterEventMode()
                self._end_event()

    def _before(self, t: float) -> bool:
        return self._time < t - _SAME_TIME * max(1.0, abs(t))

    def _is_due(self) -> bool:
        return self._next_event is not None and not self._before(self._next_event)

    def _completed_step(self) -> bool:
        if not self._archive.interface_type.needsCompletedIntegratorStep:
            return False
        step_event, terminate = self._fmu.completedIntegratorStep()
        if terminate:
            raise EndRequested(self.name, self._time)
        return bool(step_event)


class Model2Unit(ModelExchangeUnit, Fmu2Unit):
    """An FMI 2.0 Model Exchange FMU."""

    @override
    def _new_discrete_states(self) -> tuple[bool, bool, bool, bool, bool, float]:
        return self._fmu.newDiscreteStates()

    @override
    def get_derivatives(self, dx: Any, n: int) -> None:
        self._fmu.getDerivatives(dx, n)

    @override
    def _count(self) -> tuple[int, int]:
        description = self._archive.description
        return description.numberOfContinuousStates, description.numberOfEventIndicators


class Model3Unit(ModelExchangeUnit, Fmu3Unit):
    """An FMI 3.0 Model Exchange FMU."""

    @override
    def _new_discrete_states(self) -> tuple[bool, bool, bool, bool, bool, float]:
        return self._fmu.updateDiscreteStates()

    @override
    def get_derivatives(self, dx: Any, n: int) -> None:
        self._fmu.getContinuousStateDerivatives(dx, n)

    @override
    def _count(self) -> tuple[int, int]:
        return self._fmu.getNumberOfContinuousStates(), self._fmu.getNumberOfEventIndicators()
