"""The experiment: how long a system is run, in which steps, by which algorithm, and what is recorded of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final, TypeAlias

from components.interfaces.problem import choices, refuse
from orchestrator.system.scene import Scene
from orchestrator.system.system import System

STEP: Final = 0.1
"""[s] Macro step where neither a file nor a person says one; SSP itself has no place for it."""


class Algorithm(StrEnum):
    """How the units exchange data and step."""

    SEQUENTIAL = "sequential"
    JACOBI = "jacobi"
    CLOCKED = "clocked"


def algorithm_named(name: str) -> Algorithm:
    """The algorithm of this name. Raises `RequestError`."""
    if name not in set(Algorithm):
        raise refuse("algorithm", f"`{name}`", choices(Algorithm))
    return Algorithm(name)


def macro_step(h: float) -> float:
    """A macro step [s] that can be stepped with. Raises `RequestError`."""
    if not (math.isfinite(h) and h > 0):
        raise refuse("step", f"{h:g} s", "a positive number of seconds")
    return h


def last_tick(h: float, until: float) -> int:
    """The tick at which a run ends.

    Args:
        h: The macro step [s].
        until: The stop time [s].

    Returns:
        The number of macro steps from 0 s to the stop time.

    Raises:
        RequestError: The stop time is negative, or no whole number of macro steps.
    """
    macro_step(h)
    if not (math.isfinite(until) and until >= 0):
        raise refuse("stop time", f"{until:g} s", "a number of seconds, 0 or more")
    ticks = round(until / h)
    if abs(ticks * h - until) > 1e-9 * max(1.0, until):
        raise refuse("stop time", f"{until:g} s", f"a whole number of steps of {h:g} s", f"Try {ticks * h:g} s.")
    return ticks


Choice: TypeAlias = Mapping[str, int]
"""Keep the signals that fit a pattern at every n-th tick, 0 for never; the last pattern that fits counts."""


EVERYTHING: Final[Choice] = {"*": 1}


@dataclass(frozen=True)
class Scenario:
    """A system with an experiment, ready to run."""

    name: str
    title: str
    system: System
    scene: Scene | None
    """The road and the boxes of the vehicles, where they are known."""
    h: float
    """Macro step [s]."""
    until: float
    """Stop time [s]."""
    sources: Mapping[str, Mapping[str, Any]]
    """Value, unit and source of every parameter, by full path."""
    record: Choice = field(default_factory=lambda: dict(EVERYTHING))
    """Which signals are recorded at every how many ticks."""
    algorithm: Algorithm = Algorithm.SEQUENTIAL
    solve_loops: bool = False
    """Whether algebraic loops are solved by iteration instead of being refused."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the system before it runs."""
