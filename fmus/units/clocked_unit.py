"""An FMI 3.0 Co-Simulation FMU that is run with Event Mode."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from typing_extensions import override

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.toolchain.fmpy_library import FMICallException
from fmus.units.event_mode import EventError, EventMode
from fmus.units.fmu_unit import Fmu3Unit
from fmus.units.unit import Column, Operation, UnitError, views


class ClockedUnit(Fmu3Unit):
    """As `Fmu3Unit`, until `use_events` is said."""

    _events: EventMode | None = None

    @override
    def use_events(self, h: float) -> None:
        self._free_instance()
        try:
            self._fmu.instantiate(loggingOn=True, eventModeUsed=True, earlyReturnAllowed=True, logMessage=self._logged)
        except Exception as error:  # FMPy raises bare Exception
            raise UnitError(self.name, f"could not be instantiated with Event Mode ({error})", self.messages) from error
        self._component = self._address()
        self._events = EventMode(self._fmu, self.interface.clocks, h)

    @property
    def events(self) -> EventMode:
        """What the unit does at an instant, once `use_events` has been said."""
        assert self._events is not None  # noqa: S101 - the schedule asks only units that use Event Mode
        return self._events

    @override
    def bind(self, inputs: Mapping[Type, Column], outputs: Mapping[Type, Column]) -> None:
        super().bind(inputs, outputs)
        if self._events is not None and self._archive.clocks_of:
            self._setters = self._by_clock("Set", self.interface.inputs, inputs)
            self._getters = self._by_clock("Get", self.interface.outputs, outputs)

    def _by_clock(
        self, direction: str, variables: tuple[Variable, ...], columns: Mapping[Type, Column]
    ) -> list[Operation]:
        """A call for each variable; that of a clocked one does nothing while none of its clocks ticks."""
        made: list[Operation] = []
        slots = views(variables, columns)
        for variable in variables:
            move = self._mover(direction, [variable], slots[variable.name])
            clocks = self._archive.clocks_of.get(variable.name)
            made.append(move if clocks is None else self._while_active(move, clocks))
        return made

    def _while_active(self, move: Operation, clocks: frozenset[int]) -> Operation:
        return lambda: move() if clocks & self.events.active else 0

    @override
    def exit_initialization(self) -> None:
        if self._events is not None:
            self._event("the clocks could not be set", self._events.prepare)
        super().exit_initialization()
        if self._events is not None:
            self._event("the clocks could not be read", self._events.begin)

    @override
    def activate(self, t: float, h: float) -> object:
        return self._event("Event Mode failed", lambda: self.events.activate(t))

    @override
    def update(self, t: float, h: float) -> object:
        return self._event("the discrete states could not be updated", lambda: self.events.update(t))

    @override
    def step(self, t: float, h: float) -> object:
        if self._events is None:
            return super().step(t, h)
        return self._event("the step failed", lambda: self.events.step(self._advance, t, h))

    def _advance(self, t: float, h: float) -> tuple[int, bool, bool, float]:
        """Step; gives status, whether an event is needed, whether the FMU asks for the end, and the time reached."""
        status = self._do_step(self._component, t, h, 1, *self._results)
        event, terminate, early = (bool(flag) for flag in self._flags.raw)
        return int(status), event or early, terminate, self._reached.value if event or early else t + h

    @override
    def fired(self) -> set[str]:
        found = set(self.events.fired)
        self.events.fired.clear()
        return found

    @override
    def trigger(self, clock: str) -> None:
        self.events.trigger(clock)

    def _event(self, action: str, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except (FMICallException, EventError) as error:
            raise UnitError(self.name, f"{action}: {error}", self.messages) from error
