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
"""[s] The macro step unless a file or a person gives one; SSP itself has no element for it."""


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


def last_tick(h: float, until: float) -> int:
    """The tick at which a run ends.

    Args:
        h: The macro step [s].
        until: The stop time [s].

    Returns:
        The number of macro steps from 0 s to the stop time.

    Raises:
        RequestError: The stop time is negative, or not a whole number of macro steps.
    """
    macro_step(h)
    if not (math.isfinite(until) and until >= 0):
        raise refuse("stop time", f"{until:g} s", "a number of seconds, 0 or more")
    ticks = round(until / h)
    if abs(ticks * h - until) > 1e-9 * max(1.0, until):
        raise refuse("stop time", f"{until:g} s", f"a whole number of steps of {h:g} s", f"Try {ticks * h:g} s.")
    return ticks


Choice: TypeAlias = Mapping[str, int]
"""At every how many ticks the signals that match a pattern are recorded, 0 for never; the last match counts."""

EVERYTHING: Final[Choice] = {"*": 1}
"""All signals at every tick."""


@dataclass(frozen=True)
class Scenario:
    """A system with an experiment, ready to run."""

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
    record: Choice = field(default_factory=lambda: dict(EVERYTHING))
    """Which signals are recorded, and at every how many ticks."""
    algorithm: Algorithm = Algorithm.SEQUENTIAL
    solve_loops: bool = False
    """Whether algebraic loops are solved by iteration instead of being refused."""
    remarks: tuple[str, ...] = ()
    """What a person should know of the system before it runs."""
