"""The times of a run where files leave them open: chosen from what the FMUs suggest, and every deviation is told."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import isfinite
from typing import Final

from fmus.unit_interface import SuggestedExperiment
from orchestrator.system.experiment import MOST_TICKS, STEP, Scenario

_MUCH_LONGER: Final = 10
"""How many times longer than the preferred step a step is told although the unit takes any."""
_ROUNDING: Final = 1e-9
"""By how much a ratio of times may miss a whole number."""


def suggested_step(suggestions: Mapping[str, SuggestedExperiment]) -> tuple[float, str]:
    """The macro step [s] that fits FMUs of which no file and no person says the step.

    Args:
        suggestions: What each unit suggests.

    Returns:
        The smallest step that a unit prefers; else `STEP`, as a whole multiple of the longest internal step. And in
        words, why.
    """
    preferred = {name: s.step for name, s in suggestions.items() if s.step}
    if preferred:
        return min(preferred.values()), "the smallest that its units prefer"
    fixed = max((s.fixed_step or 0.0 for s in suggestions.values()), default=0.0)
    if fixed:
        return max(1, int(STEP / fixed + _ROUNDING)) * fixed, f"whole internal steps of {fixed:g} s"
    return STEP, ""


def whole_steps(start: float, h: float, until: float) -> tuple[float, tuple[str, ...]]:
    """The stop time [s] of a file as a whole number of macro steps, never beyond it, and a remark if it differs.

    Args:
        start: The start time [s].
        h: The macro step [s].
        until: The stop time that the file says [s].
    """
    if not 0 <= (until - start) / h < MOST_TICKS:  # what is wrong with it is told where the run is prepared
        return until, ()
    ticks = int((until - start) / h + min(0.5, _ROUNDING * max(1.0, abs(until / h))))  # until / h may be infinite
    last = start + ticks * h
    if abs(last - until) <= _ROUNDING * max(1.0, abs(until)):
        return until, ()
    cut = f"the last whole step of {h:g} s before the file's stop time, {until:g} s"
    return last, (f"the run ends at {last:g} s, {cut}",)


def deviations(scenario: Scenario) -> Iterator[str]:
    """What the units of a scenario suggest of its times, and do not get."""
    for name, source in scenario.system.units.items():
        wished = source.suggested
        h = scenario.h * float(scenario.system.steps.get(name, Fraction(1)))
        ratio = h / wished.fixed_step if wished.fixed_step else 1.0
        if not isfinite(ratio) or abs(ratio - round(ratio)) > _ROUNDING * ratio or not round(ratio):
            yield (
                f"`{name}` computes in steps of {wished.fixed_step:g} s, of which its step of {h:g} s is no whole"
                " multiple: its results lie at other times than it is asked for"
            )
        elif wished.step and not wished.any_step and abs(h - wished.step) > _ROUNDING * h:
            yield f"`{name}` prefers steps of {wished.step:g} s, and is not said to take others; it gets {h:g} s"
        elif wished.step and h > wished.step * _MUCH_LONGER * (1 - _ROUNDING):
            yield (
                f"`{name}` prefers steps of {wished.step:g} s, and gets {h:g} s: its results may be coarse, or grow"
                " without bound; `macrostep check FILE --passport` tries it"
            )
        if wished.start and wished.start != scenario.start:
            yield f"the experiment of `{name}` has the start time {wished.start:g} s; this run has {scenario.start:g} s"
