"""FMI 3.0 Event Mode: the actions of one FMU at an instant, and its steps from one instant to the next.

At t_k: `activate` enters Event Mode and makes the clocks tick that are due or were triggered; then inputs are set and
outputs are read; `update` iterates the discrete states and notes which output clocks tick. `step` leads to t_{k+1}: it
stops wherever a clock of the FMU is due or the FMU returns early, handles that instant with the inputs as they are, and
goes on; likewise an event at t_{k+1} itself, unless `activate` follows before anybody reads. Output clocks that tick in
between are forwarded at the next communication point.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

from fmus.clock import SET_BY_IMPORTER, Clock
from fmus.toolchain.fmpy_library import (
    fmi3Float64,
    fmi3IntervalChanged,
    fmi3IntervalQualifier,
    fmi3ValueReference,
)
from fmus.units.unit import EndRequested, is_failure

EVENT_ITERATIONS: Final = 1000
"""The most event iterations at one instant; an FMU that needs more is assumed never to settle."""


class EventError(RuntimeError):
    """An FMU that cannot continue at an instant."""


class StepResult(NamedTuple):
    """The result of one call of the FMU's step function."""

    status: int
    """The FMI status."""
    interrupted: bool
    """Whether the FMU needs an event or returned early."""
    terminate: bool
    """Whether the FMU asks for the end of the simulation."""
    reached: float
    """[s] The time that was reached."""


class EventMode:
    """The event handling of one running FMU.

    The methods raise `EventError`, FMPy's `FMICallException` and `EndRequested`.

    Args:
        name: Name of the unit.
        fmu: FMPy's object, whose instance was made with Event Mode.
        clocks: All clocks of the FMU.
        h: The communication step of the unit [s].
        settles: Whether a step handles the event at its end.
    """

    def __init__(self, name: str, fmu: Any, clocks: tuple[Clock, ...], h: float, *, settles: bool = False) -> None:
        self._name = name
        self._fmu = fmu
        self._h = h
        self.settles = settles
        self.running = False
        """Whether the initialisation is over."""
        self.now = 0.0
        """[s] The time of the FMU."""
        self._time_based = [c for c in clocks if c.is_time_based]
        self._outputs = [c for c in clocks if c.causality == "output"]
        self._references = {c.name: c.reference for c in clocks}
        self._next: dict[int, float] = {}
        """[s] The next tick of each time-based clock."""
        self._ticks: dict[int, tuple[float, float, int]] = {}
        """First tick and interval [s] of each clock that ticks regularly, and how often it has ticked since."""
        self._triggered: set[int] = set()
        self._in_event_mode = False
        self.active: frozenset[int] = frozenset()
        """Clocks that tick at this instant: only their variables may be set and read."""
        self._fired: set[str] = set()
        """Output clocks that have ticked and were not forwarded yet, by name."""

    def saved(self) -> dict[str, Any]:
        """Where the clocks are, as plain values."""
        return {
            "now": self.now,
            "running": self.running,
            "next": [[reference, when] for reference, when in self._next.items()],
            "ticks": [[reference, *regular] for reference, regular in self._ticks.items()],
            "triggered": sorted(self._triggered),
            "in_event_mode": self._in_event_mode,
            "active": sorted(self.active),
            "fired": sorted(self._fired),
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Go back to where the clocks were when `saved` gave this; the FMU goes back by itself."""
        self.now, self.running, self._in_event_mode = saved["now"], saved["running"], saved["in_event_mode"]
        self._next = dict(saved["next"])
        self._ticks = {reference: (first, interval, n) for reference, first, interval, n in saved["ticks"]}
        self._triggered, self._fired = set(saved["triggered"]), set(saved["fired"])
        self.active = frozenset(saved["active"])

    def prepare(self) -> None:
        """Give the clocks that have none the macro step as their interval; in Initialization Mode."""
        own = [c for c in self._time_based if c.interval_variability in SET_BY_IMPORTER and c.interval is None]
        if own:
            references = (fmi3ValueReference * len(own))(*(c.reference for c in own))
            intervals = (fmi3Float64 * len(own))(*[self._h] * len(own))
            self._fmu.setIntervalDecimal(references, intervals)

    def begin(self, start: float = 0.0) -> None:
        """Begin after Initialization Mode, at `start` [s]: in Event Mode, with the first tick of time-based clocks."""
        self._in_event_mode = self.running = True
        self.now = start
        for clock in self._time_based:
            if clock.interval_variability == "constant":
                self._regular(clock.reference, start + clock.shift, clock.interval or self._h)
            elif clock.interval_variability in SET_BY_IMPORTER:
                interval = self._h if clock.interval is None else self._interval(clock)[0]
                self._regular(clock.reference, start + self._shift(clock), interval)
            else:
                self._ask(clock, start)
        if self.settles:
            self.update(start)

    def activate(self, t: float) -> None:
        """Enter Event Mode at `t` and make the clocks tick that are due, or were triggered."""
        self._enter(t, self._triggered)
        self._triggered = set()

    def interrupt(self) -> None:
        """Enter Event Mode at the present time, where clocks that others have triggered wait for their instant."""
        self._enter(self.now, set())

    def update(self, t: float) -> None:
        """Iterate the discrete states until they no longer change."""
        for _ in range(EVENT_ITERATIONS):
            self._fired |= {clock.name for clock in self._outputs if self._fmu.getClock([clock.reference])[0]}
            again, terminate, *_ = self._fmu.updateDiscreteStates()
            self.active = frozenset()
            if terminate:
                raise EndRequested(self._name, t)
            if not again:
                break
        else:
            raise EventError(f"its discrete states do not come to rest at {t:g} s ({EVENT_ITERATIONS} iterations)")
        for clock in self._time_based:
            if clock.interval_variability in {"tunable", "changing", "countdown"}:
                self._ask(clock, t)

    def step(self, do_step: Callable[[float, float], StepResult], t: float, h: float) -> object:
        """Lead from `t` to `t + h` [s] and handle all instants in between.

        Args:
            do_step: Calls the FMU's step function for a time and a length [s].
            t: The present communication point.
            h: The communication step.

        Returns:
            0, or the FMI status of the step that failed.
        """
        now, end, stays = t, t + h, 0
        while now < end - _tolerance(end):
            if self._in_event_mode:
                self._fmu.enterStepMode()
                self._in_event_mode = False
            due = min(self._next.values(), default=end)
            target = due if now + _tolerance(due) < due < end - _tolerance(end) else end
            status, interrupted, terminate, reached = do_step(now, target - now)
            if is_failure(status):
                return status
            if not now - _tolerance(now) <= reached <= target + _tolerance(target):
                raise EventError(f"it says that it has reached {reached:g} s in a step from {now:g} s to {target:g} s")
            if terminate:
                raise EndRequested(self._name, reached)
            stays = stays + 1 if reached <= now else 0
            if stays > EVENT_ITERATIONS or (stays and not interrupted):
                raise EventError(f"it returned early from its step without having moved, at {now:g} s")
            self.now = now = reached if reached < target - _tolerance(target) else target
            if now < end - _tolerance(end) or (interrupted and self.settles):
                self._enter(now, set())  # clocks that other units trigger wait for the communication point
                self.update(now)
        return 0

    def take_fired(self) -> set[str]:
        """The output clocks that have ticked since this was called last, by name."""
        fired, self._fired = self._fired, set()
        return fired

    def trigger(self, clock: str) -> None:
        """Make a triggered input clock tick when the unit is activated next."""
        self._triggered.add(self._references[clock])

    def _enter(self, t: float, triggered: set[int]) -> None:
        if not self._in_event_mode:
            self._fmu.enterEventMode()
            self._in_event_mode = True
        due = {reference for reference, when in self._next.items() if when <= t + _tolerance(t)}
        active = sorted(due | triggered)
        self.active = frozenset(active)
        if active:
            self._fmu.setClock(active, [True] * len(active))
        for reference in due:
            del self._next[reference]
            if reference in self._ticks:
                first, interval, n = self._ticks[reference]
                self._ticks[reference] = (first, interval, n + 1)
                self._next[reference] = first + (n + 1) * interval

    def _regular(self, reference: int, first: float, interval: float) -> None:
        if not interval > 0:
            raise EventError(f"the clock with value reference {reference} has the interval {interval:g} s")
        self._ticks[reference] = (first, interval, 0)
        self._next[reference] = first

    def _ask(self, clock: Clock, t: float) -> None:
        """Read a new interval, which is counted from `t`."""
        interval, qualifier = self._interval(clock)
        if qualifier != fmi3IntervalChanged:
            return
        if not interval >= 0:
            raise EventError(f"the clock with value reference {clock.reference} has the interval {interval:g} s")
        if clock.interval_variability == "tunable" or (clock.interval_variability == "changing" and interval > 0):
            known = self._ticks.get(clock.reference)
            if known is None or known[1] != interval:
                self._regular(clock.reference, t + interval, interval)
        else:  # a countdown ticks once
            self._next[clock.reference] = t + interval

    def _interval(self, clock: Clock) -> tuple[float, int]:
        references, intervals = (fmi3ValueReference * 1)(clock.reference), (fmi3Float64 * 1)()
        qualifiers = (fmi3IntervalQualifier * 1)()
        self._fmu.getIntervalDecimal(references, intervals, qualifiers)
        return float(intervals[0]), int(qualifiers[0])

    def _shift(self, clock: Clock) -> float:
        if clock.interval is None:
            return clock.shift
        references, shifts = (fmi3ValueReference * 1)(clock.reference), (fmi3Float64 * 1)()
        self._fmu.getShiftDecimal(references, shifts)
        return float(shifts[0])


def _tolerance(t: float) -> float:
    return 1e-9 * max(1.0, abs(t))
