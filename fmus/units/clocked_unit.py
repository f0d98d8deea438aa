"""An FMI 3.0 Co-Simulation FMU that can be run with Event Mode."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from typing_extensions import override

from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.toolchain.fmpy_library import FMICallException
from fmus.units.capabilities import EventCapability
from fmus.units.event_mode import EventError, EventMode, StepResult
from fmus.units.fmu_unit import Fmu3Unit
from fmus.units.unit import Operation, TypedColumns, Unit, UnitError, views
from fmus.units.value_calls import AccessVerb


class ClockedUnit(Fmu3Unit):
    """As `Fmu3Unit`, until its events are used."""

    def __init__(self, name: str, archive: Archive) -> None:
        super().__init__(name, archive)
        self.events = self._events = ClockedEvents(self, self._fmu, self._instantiate_again)

    def _instantiate_again(self) -> None:
        """Replace the instance by one with Event Mode."""
        self._free_instance()
        try:
            self._fmu.instantiate(loggingOn=True, eventModeUsed=True, earlyReturnAllowed=True, logMessage=self._logged)
        except Exception as error:  # FMPy raises bare Exception
            raise UnitError(self.name, f"could not be instantiated with Event Mode ({error})", self.messages) from error
        self._take_address()

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns) -> None:
        super().bind(inputs, outputs)
        if self._events.mode is not None and self._archive.clocks_of:
            self._setters = list(self._by_clock("Set", self.interface.inputs, inputs, self._events.mode))
            self._getters = list(self._by_clock("Get", self.interface.outputs, outputs, self._events.mode))

    def _by_clock(
        self, direction: AccessVerb, variables: Iterable[Variable], columns: TypedColumns, mode: EventMode
    ) -> Iterable[Operation]:
        """A call for each variable; that of a clocked one does nothing while none of its clocks ticks."""
        slots = views(tuple(variables), columns)
        for variable in variables:
            move = self._calls.mover(direction, [variable], slots[variable.name])
            clocks = self._archive.clocks_of.get(variable.name)
            yield move if clocks is None else _while_active(move, clocks, mode)

    @override
    def exit_initialization(self) -> None:
        mode = self._events.mode
        if mode is None:
            super().exit_initialization()
            return
        self._events.check("the clocks could not be set", mode.prepare)
        super().exit_initialization()
        self._events.check("the clocks could not be read", mode.begin)

    @override
    def step(self, t: float, h: float) -> object:
        mode = self._events.mode
        if mode is None:
            return super().step(t, h)
        return self._events.check("the step failed", mode.step, self._advance, t, h)

    def _advance(self, t: float, h: float) -> StepResult:
        status = self._do_step(self._component, t, h, 1, *self._results)
        event, terminate, early = (bool(flag) for flag in self._flags.raw)
        interrupted = event or early
        return StepResult(int(status), interrupted, terminate, self._reached.value if interrupted else t + h)


class ClockedEvents(EventCapability):
    """Event Mode of a `ClockedUnit`.

    Args:
        unit: The unit, for its messages and its clocks.
        fmu: The FMU as an object of FMPy.
        instantiate_again: Replaces the instance by one with Event Mode.
    """

    def __init__(self, unit: Unit, fmu: Any, instantiate_again: Callable[[], None]) -> None:
        self._unit, self._fmu, self._instantiate_again = unit, fmu, instantiate_again
        self.mode: EventMode | None = None
        """The events of the present instance, once they are used."""

    def check(self, action: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function; `action` names the failure in the error. Raises `UnitError`."""
        try:
            return function(*arguments)
        except (FMICallException, EventError) as error:
            raise UnitError(self._unit.name, f"{action}: {error}", self._unit.messages) from error

    @property
    def _used(self) -> EventMode:
        assert self.mode is not None  # noqa: S101 - the schedule asks only units that use Event Mode
        return self.mode

    @override
    def use(self, h: float) -> None:
        self._instantiate_again()
        self.mode = EventMode(self._fmu, self._unit.interface.clocks, h)

    @override
    def activate(self, t: float, h: float) -> object:
        return self.check("Event Mode failed", self._used.activate, t)

    @override
    def update(self, t: float, h: float) -> object:
        return self.check("the discrete states could not be updated", self._used.update, t)

    @override
    def fired(self) -> set[str]:
        return self._used.take_fired()

    @override
    def trigger(self, clock: str) -> None:
        self._used.trigger(clock)


def _while_active(move: Operation, clocks: frozenset[int], mode: EventMode) -> Operation:
    return lambda: move() if clocks & mode.active else 0
