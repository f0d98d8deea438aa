"""Which signals are kept at which ticks, by the patterns of what is recorded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from orchestrator.stepping.observation import applied
from orchestrator.system.experiment import EVERYTHING, Choice
from orchestrator.system.patterns import fits
from orchestrator.system.system import System


def paces(system: System, choice: Choice) -> dict[str, int]:
    """At every how many ticks each element of what units show is kept.

    A signal that fits no pattern is not kept, unless all patterns only leave something out.

    Args:
        system: The system whose signals are kept.
        choice: Pattern by pattern, at every how many ticks.

    Returns:
        Numbers of ticks by full path of an element, 0 for never.

    Raises:
        RequestError: A pattern fits no signal.
    """
    raise_if_any(_unfitting(system, choice))
    found: dict[str, int] = {}
    for unit, source in system.units.items():
        outputs = len(source.interface.outputs)
        of_outputs, of_others = (applied(choice, source, to_outputs=is_output) for is_output in (True, False))
        for i, variable in enumerate(source.interface.recorded):
            pace = (of_outputs if i < outputs else of_others).pace(f"{unit}.{variable.name}")
            found |= dict.fromkeys((f"{unit}.{element}" for element in variable.elements), min(pace, _ONCE))
    return found


def _unfitting(system: System, choice: Choice) -> Iterator[Problem]:
    """The problems of patterns that no signal fits; that of everything fits a system that has none."""
    paths = [f"{unit}.{v.name}" for unit, source in system.units.items() for v in source.interface.recorded]
    for pattern in choice:
        if pattern in EVERYTHING or any(fits(path, pattern) for path in paths):
            continue
        others = [f"{unit}.{name}" for unit, source in system.units.items() for name in source.observable]
        if not any(fits(path, pattern) for path in others):
            known = [*paths, *others]
            yield Problem(f"record {pattern}", "a pattern that no signal fits", choices(paths), _meant(pattern, known))


def _meant(pattern: str, paths: Iterable[str]) -> str:
    if any(path.startswith(f"{pattern}.") for path in paths):  # a unit, or a bus
        return f"Did you mean `{pattern}.*`?"
    return did_you_mean(pattern, paths)


_ONCE: Final = 2**31
"""[ticks] No run is as long, so that a signal of this pace or a larger one is kept at the start only."""


def without_gaps(system: System, choice: Choice) -> set[str]:
    """Full paths of the elements that are kept in every row: those at every tick, or all if all have the same pace."""
    kept = {path: every for path, every in paces(system, choice).items() if every}
    return {path for path, every in kept.items() if every == 1 or len(set(kept.values())) == 1}
