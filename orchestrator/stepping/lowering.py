"""The schedule lowered to prepared calls: what happens at a tick, unit by unit, with nothing left to decide."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import lcm
from typing import TypeAlias

from fmus.units.capabilities import EventCapability
from fmus.units.unit import Unit, UnitError, is_failure
from orchestrator.stepping.algebraic_loops import AlgebraicLoop
from orchestrator.stepping.schedule import Act, Acts, Schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.system.system import Connection, System

Call: TypeAlias = tuple[Callable[..., object], bool, str]
"""A function, whether it is given the time and the step, and the unit it belongs to."""


class CompiledSchedule:
    """The calls of every macro step. Units with longer steps act at some ticks only, in a pattern that repeats.

    Args:
        system: The whole system.
        schedule: Its schedule.
        units: All running units by name, bound to the table.
        table: The signal table.
        start: The start time [s].
    """

    def __init__(
        self,
        system: System,
        schedule: Schedule,
        units: Mapping[str, Unit],
        table: SignalTable,
        start: float = 0.0,
    ) -> None:
        self._schedule, self._units, self._table, self._start = schedule, units, table, start
        self._steps = {name: system.steps.get(name, Fraction(1)) for name in units}
        self.period = lcm(*(ratio.numerator for ratio in self._steps.values())) if units else 1
        """[ticks] After how many the calls are the same again."""
        self._loops = {group: AlgebraicLoop(system, group, schedule, units, table) for group in schedule.loops}
        wires = [c for c in system.clock_connections if {c.unit, c.source} <= schedule.events]
        self._events = {name: events_of(units[name]) for name in schedule.events}
        self._forwards = {name: _forward(name, wires, self._events) for name in {wire.source for wire in wires}}
        self._before: dict[int, list[Call]] = {}
        self._after: dict[int, list[Call]] = {}

    def before(self, tick: int) -> list[Call]:
        """The calls that complete the instant of `tick`."""
        phase = tick % self.period
        if phase not in self._before:
            self._before[phase] = list(self._calls(self._schedule.before, phase, after=False))
        return self._before[phase]

    def after(self, tick: int) -> list[Call]:
        """The calls that lead from `tick` to the next."""
        phase = tick % self.period
        if phase not in self._after:
            self._after[phase] = list(self._calls(self._schedule.after, phase, after=True))
        return self._after[phase]

    def _calls(self, acts: Acts, phase: int, *, after: bool) -> Iterator[Call]:
        for act, names in acts:
            if act is Act.SOLVE:
                yield self._loops[names].solve, True, ", ".join(names)
                continue
            name = names[0]
            # a step that ends at the next tick is taken, and its outcome shown, just before that tick
            ends = after and act in (Act.STEP, Act.GET)
            if not (phase + ends) % self._steps[name].numerator:
                yield from self._act(act, name, ends=ends)

    def _act(self, act: Act, name: str, *, ends: bool) -> Iterator[Call]:
        unit = self._units[name]
        if act is Act.STEP:
            yield UnitStep(unit, self._steps[name], self._start, ends=ends), True, name
            if name in self._schedule.events and name in self._forwards:
                yield self._forwards[name], False, name
        elif act is Act.ACTIVATE:
            yield self._events[name].activate, True, name
        elif act is Act.UPDATE:
            yield self._events[name].update, True, name
            if name in self._forwards:
                yield self._forwards[name], False, name
        elif act is Act.SET:
            for function in self._table.giving(unit):
                yield function, False, name
        else:
            for function in unit.getters():
                yield function, False, name


class UnitStep:
    """The step of a unit, which may be a multiple or a part of the macro step.

    Args:
        unit: The unit.
        ratio: Its step in macro steps.
        start: The start time of the run [s].
        ends: Whether it ends at the next tick, and so may have begun before the present one.
    """

    def __init__(self, unit: Unit, ratio: Fraction, start: float = 0.0, *, ends: bool = False) -> None:
        self.unit, self._start = unit, start
        self.multiple, self.parts = ratio.numerator, ratio.denominator
        self.earlier = self.multiple - 1 if ends else 0
        """How many ticks before the present one it begins."""

    def __call__(self, t: float, h: float) -> object:
        """Carry it out at the present instant `t`, with the macro step `h` [s]; returns the FMI status."""
        if self.multiple == self.parts == 1:
            return self.unit.step(t, h)
        for times in self._times(t, h):
            if status := self.unit.step(*times):
                if is_failure(status):
                    return status
                self.unit.warned(status)
        return 0

    def _times(self, t: float, h: float) -> Iterator[tuple[float, float]]:
        """The begin and the length of each of its steps [s]."""
        if self.multiple > 1:
            begin = round((t - self._start) / h) - self.earlier
            yield self._start + begin * h, self.multiple * h
        else:
            for part in range(self.parts):
                yield t + part * (h / self.parts), h / self.parts


def events_of(unit: Unit) -> EventCapability:
    """Event Mode of a unit that the schedule runs with it. Raises `UnitError` where there is none."""
    if unit.events is None:  # the schedule asks the unit's interface, which says the same
        raise UnitError(unit.name, "could not be instantiated with Event Mode", unit.messages)
    return unit.events


def _forward(source: str, wires: Sequence[Connection], events: Mapping[str, EventCapability]) -> Callable[[], None]:
    """Pass the ticks of a unit's output clocks on."""
    targets = [(wire.output, events[wire.unit], wire.input) for wire in wires if wire.source == source]

    def forward() -> None:
        fired = events[source].fired()
        for clock, target, triggered in targets:
            if clock in fired:
                target.trigger(triggered)

    return forward
