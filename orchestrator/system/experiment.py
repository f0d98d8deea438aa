"""The experiment: how long a system is run, in which steps, by which algorithm, and what is recorded of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, ClassVar, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.problem import choices, refuse
from orchestrator.system.scene import Scene
from orchestrator.system.system import System

STEP: Final = 0.1
"""[s] The macro step unless a file or a person gives one; SSP itself has no element for it."""
MOST_TICKS: Final = 10**15
"""The most steps of a run; NumPy and Rerun count them in 64 bits, and times in floating-point numbers."""


class Algorithm(StrEnum):
    """How the units exchange data and step."""

    SEQUENTIAL = "sequential"
    JACOBI = "jacobi"
    CLOCKED = "clocked"


def algorithm_named(name: str) -> Algorithm:
    """The algorithm of a name. Raises `RequestError` where there is none."""
    if name not in set(Algorithm):
        raise refuse("algorithm", f"`{name}`", choices(Algorithm))
    return Algorithm(name)


def macro_step(h: float) -> float:
    """Check a macro step.

    Args:
        h: The macro step [s].

    Returns:
        The same macro step [s].

    Raises:
        RequestError: It is not a positive, finite number.
    """
    if not (math.isfinite(h) and h > 0):
        raise refuse("step", f"{h:g} s", "a positive number of seconds")
    return h


def relative_tolerance(value: float) -> float:
    """Check a relative tolerance. Raises `RequestError` where it is none."""
    if not (math.isfinite(value) and value > 0):
        raise refuse("tolerance", f"{value:g}", "a positive number, such as 1e-6")
    return value


_ROUNDING: Final = 1e-9
"""By how many ticks a time may miss its tick, relative to the number of ticks."""


@dataclass(frozen=True)
class Tick:
    """One communication point."""

    tick: int
    time: float
    """[s] `start + tick * h`."""


@dataclass(frozen=True)
class TimeGrid:
    """The communication points of a run: ``start + tick * h``, never a running sum.

    Args:
        h: The macro step [s].
        until: The stop time [s].
        start: The start time [s].

    Raises:
        RequestError: The stop time lies before the start time, or not a whole number of macro steps after it.
    """

    h: float
    until: float
    start: float = 0.0

    def __post_init__(self) -> None:
        macro_step(self.h)
        if not math.isfinite(self.start):
            raise refuse("start time", f"{self.start:g} s", "a number of seconds")
        if not (math.isfinite(self.until) and self.until >= self.start):
            raise refuse("stop time", f"{self.until:g} s", f"a number of seconds, {self.start:g} or more")
        if not (self.until - self.start) / self.h < MOST_TICKS:
            found = f"{self.until:g} s, which is {(self.until - self.start) / self.h:.3g} steps of {self.h:g} s away"
            raise refuse("stop time", found, f"at most {MOST_TICKS:.0e} steps", "Choose a longer step.")
        nearest = self.at(self.last_tick)
        if abs(nearest - self.until) > 1e-9 * max(1.0, abs(self.until)):
            after = f" after the start at {self.start:g} s" if self.start else ""
            valid = f"a whole number of steps of {self.h:g} s{after}"
            raise refuse("stop time", f"{self.until:g} s", valid, f"Try {nearest:g} s.")

    @property
    def last_tick(self) -> int:
        """The tick at which the run ends."""
        return round((self.until - self.start) / self.h)

    def at(self, tick: int) -> float:
        """The time of a tick [s]."""
        return self.start + tick * self.h

    def ticks(self, times: Any) -> NDArray[np.int64]:
        """The tick of each row, (n,), from the times of the rows [s]; a row between two ticks belongs to the later."""
        after = (np.asarray(times, dtype=float) - self.start) / self.h
        return np.ceil(after - _ROUNDING * np.maximum(1.0, np.abs(after))).astype(np.int64)

    def times_until(self, time: float) -> NDArray[np.float64]:
        """The time of each tick [s] up to an instant [s], `(n,)`."""
        return self._times(min(max(int(self.ticks([time])[0]), 0), self.last_tick))

    def _times(self, last: int) -> NDArray[np.float64]:
        return np.asarray(self.start + np.arange(last + 1) * self.h, dtype=np.float64)

    @property
    def times(self) -> NDArray[np.float64]:
        """The time of each tick [s], (ticks,). Raises `RequestError` where they do not fit into memory."""
        try:
            return self._times(self.last_tick)
        except MemoryError:
            found = f"{self.until:g} s, whose {self.last_tick + 1:.3g} steps of {self.h:g} s do not fit into memory"
            raise refuse("stop time", found, "fewer steps", "Choose a longer step.") from None


Choice: TypeAlias = Mapping[str, int]
"""At every how many ticks the signals that match a pattern are recorded, 0 for never; the last match counts."""

EVERYTHING: Final[Choice] = {"*": 1}
"""All signals at every tick."""


@dataclass(frozen=True)
class Scenario:
    """A system with an experiment, ready to run."""

    MADE_BY: ClassVar = 'Write load("static").'
    """What to do where something else is given."""
    name: str
    title: str
    system: System
    scene: Scene | None
    """The road and the box of the ego vehicle; `None` where they are not known."""
    h: float
    """Macro step [s]."""
    until: float
    """Stop time [s]."""
    sources: Mapping[str, Mapping[str, Any]]
    """Value, unit of measurement and source of every parameter, by full path."""
    start: float = 0.0
    """Start time [s]."""
    tolerance: float | None = None
    """The relative tolerance that a person wants of all FMUs."""
    record: Choice = field(default_factory=lambda: dict(EVERYTHING))
    """Which signals are recorded, and at every how many ticks."""
    algorithm: Algorithm = Algorithm.SEQUENTIAL
    solve_loops: bool = False
    """Whether algebraic loops are solved by iteration instead of being refused."""
    end_off_road: bool = False
    """Whether the run ends where the vehicle leaves the surroundings of the road."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the system before it runs."""

    @property
    def grid(self) -> TimeGrid:
        """The communication points. Raises `RequestError`."""
        return TimeGrid(self.h, self.until, self.start)
