"""What is recorded besides outputs: local variables of FMUs, and parameters, by the patterns of what is recorded.

Patterns that fit whole units (`*`, `plant.*`) are meant for outputs; any other (`plant.tyre.*`) reaches local variables
too, `plant.**` all of them. Parameters are recorded where their own name is given. A unit without outputs shows its
local variables in their place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from fmus.reading.observation import LOCAL
from orchestrator.system.experiment import Choice
from orchestrator.system.patterns import fits
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System

MOST_BY_DEFAULT: Final = 1000
"""The most local variables of a unit that are recorded without having been asked for."""


def observed(system: System, choice: Choice) -> System:
    """The same system, whose units show what a choice asks for besides their outputs.

    Args:
        system: The system.
        choice: Pattern by pattern, at every how many ticks.

    Raises:
        RequestError: The description of a variable cannot be understood.
    """
    units = {name: _observing(name, source, choice) for name, source in system.units.items()}
    unchanged = all(units[name] is source for name, source in system.units.items())
    return system if unchanged else replace(system, units=units)


def remarks(system: System, choice: Choice) -> Iterator[str]:
    """What a person should know of the units without outputs, as texts.

    Args:
        system: A system that `observed` gives for the choice.
        choice: Pattern by pattern, at every how many ticks.
    """
    for name, source in system.units.items():
        if source.interface.outputs:
            continue
        known = sum(causality == LOCAL for causality in source.observable.values())
        if not known:
            yield f"`{name}` has neither outputs nor local variables: there is nothing to record of it"
        elif known > MOST_BY_DEFAULT and not _reaching(choice):
            yield (
                f"`{name}` has no outputs: the first {MOST_BY_DEFAULT} of its {known} local variables are recorded;"
                f" --record '{name}.**' records all of them"
            )


@dataclass(frozen=True)
class Applied:
    """A choice as it applies to the outputs of a unit, or to what else it shows."""

    choice: Choice
    """The patterns that apply."""
    others: int
    """At every how many ticks a signal is kept that fits no pattern."""

    def pace(self, path: str) -> int:
        """At every how many ticks a signal is kept, 0 for never: as the last pattern says that fits its full path."""
        return next((every for pattern, every in reversed([*self.choice.items()]) if fits(path, pattern)), self.others)


def applied(choice: Choice, source: UnitSource, *, to_outputs: bool) -> Applied:
    """A choice as it applies to a unit.

    A signal that fits no pattern is not kept, unless all patterns only leave something out.

    Args:
        choice: Pattern by pattern, at every how many ticks.
        source: The unit.
        to_outputs: Whether to its outputs, or to what it shows besides.
    """
    if to_outputs or not source.interface.outputs:
        return Applied(choice, 0 if any(choice.values()) else 1)
    return Applied(_reaching(choice), 0)


def _reaching(choice: Choice) -> Choice:
    """The patterns that are meant for local variables too."""
    return {p: every for p, every in choice.items() if "." in p and p.partition(".")[2] != "*"}


def _observing(unit: str, source: UnitSource, choice: Choice) -> UnitSource:
    asked = applied(choice, source, to_outputs=False)
    if not (asked.choice or asked.others):
        return source.observing(()) if source.interface.observed else source
    explicit = Applied(_reaching(choice), 0)
    wanted: list[str] = []
    unasked = 0
    for name, causality in source.observable.items():
        path = f"{unit}.{name}"
        if path not in asked.choice and (causality != LOCAL or not asked.pace(path)):
            continue
        if not explicit.pace(path):
            unasked += 1
        if unasked <= MOST_BY_DEFAULT or explicit.pace(path):
            wanted.append(name)
    return source if wanted == [v.name for v in source.interface.observed] else source.observing(wanted)
