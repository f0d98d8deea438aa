"""Verdicts: a claim is examined in cases, and holds in all of them, in some, or in none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

TIME_METRIC: Final = "p50_us"
"""The one metric among those that decide claims which is a wall time: it differs from one reproduction to the next."""


class Status(StrEnum):
    """The outcome for a claim."""

    HOLDS = "holds"
    CONDITION = "holds under a condition"
    FAILS = "does not hold"
    OPEN = "not decided"


@dataclass(frozen=True)
class DecidingNumber:
    """A value that decides a case."""

    metric: str
    value: float
    of: str = ""
    """What was measured, where it is not the controller that the claim is about."""

    @property
    def name(self) -> str:
        """The key of the value in `report.json`."""
        return f"{self.metric} of {self.of}" if self.of else self.metric

    @property
    def is_time(self) -> bool:
        """Whether it is a wall time."""
        return self.metric == TIME_METRIC


@dataclass(frozen=True)
class Case:
    """One comparison that a claim rests on."""

    factors: Mapping[str, str]
    """What was compared: setting, baseline, tyre, ..."""
    holds: bool | None
    """None where the numbers do not decide it."""
    measured: tuple[DecidingNumber, ...]
    runs: tuple[str, ...]
    """Names of the runs that were measured."""
    note: str = ""

    @property
    def numbers(self) -> dict[str, float]:
        """The values that decide the case, by name."""
        return {number.name: number.value for number in self.measured}

    def __str__(self) -> str:
        return ", ".join(self.factors.values())


@dataclass(frozen=True)
class Verdict:
    """A claim, and what the cases say about it."""

    claim: str
    """A short identifier: C1, C2, ..."""
    words: str
    """The claim in words."""
    decided_by: str
    """The condition under which a case holds, in words."""
    cases: tuple[Case, ...]
    notes: tuple[str, ...] = ()

    @property
    def status(self) -> Status:
        """The outcome; cases that are not decided do not count."""
        decided = [case.holds for case in self.cases if case.holds is not None]
        if not decided:
            return Status.OPEN
        if all(decided):
            return Status.HOLDS
        return Status.CONDITION if any(decided) else Status.FAILS

    @property
    def condition(self) -> str:
        """The condition under which it holds, as short as the cases allow; empty where there is none."""
        if self.status is not Status.CONDITION:
            return ""
        return condition([case for case in self.cases if case.holds is not None])

    @property
    def open_cases(self) -> tuple[str, ...]:
        """The cases that are not decided."""
        return tuple(str(case) for case in self.cases if case.holds is None)


def verdict_data(verdict: Verdict) -> dict[str, Any]:
    """A verdict as plain data, without wall times: these stand in a section of their own."""
    return {
        "claim": verdict.claim,
        "words": verdict.words,
        "verdict": verdict.status.value,
        "condition": verdict.condition,
        "cannot_be_compared": list(verdict.open_cases),
        "decided_by": verdict.decided_by,
        "cases": [
            {
                "factors": dict(case.factors),
                "holds": case.holds,
                "numbers": {number.name: number.value for number in case.measured if not number.is_time},
                "runs": list(case.runs),
                "note": case.note,
            }
            for case in verdict.cases
        ],
        "notes": list(verdict.notes),
    }


def time_data(verdict: Verdict) -> list[dict[str, float]]:
    """The wall times of a verdict, case by case; empty where no case has any."""
    times = [{number.name: number.value for number in case.measured if number.is_time} for case in verdict.cases]
    return times if any(times) else []


def condition(cases: Sequence[Case]) -> str:
    """What the cases in which a claim holds have in common, in as few factors as explain it."""
    names = list(dict.fromkeys(name for case in cases for name in case.factors))
    for chosen in ([name] for name in names):
        if text := _explained(cases, chosen):
            return text
    for i, name in enumerate(names):
        for other in names[i + 1 :]:
            if text := _explained(cases, [name, other]):
                return text
    return _explained(cases, names)


def _explained(cases: Sequence[Case], names: Sequence[str]) -> str:
    """The combinations of some factors in which the claim holds, or fails; empty where these do not explain it."""
    outcomes: dict[str, set[bool]] = {}
    for case in cases:
        combination = " / ".join(f"{name} {case.factors[name]}" for name in names if name in case.factors)
        outcomes.setdefault(combination or "otherwise", set()).add(bool(case.holds))
    if any(len(values) > 1 for values in outcomes.values()):
        return ""
    good = [text for text, values in outcomes.items() if values == {True}]
    bad = [text for text, values in outcomes.items() if values == {False}]
    return f"except for {'; '.join(bad)}" if len(bad) < len(good) else f"only for {'; '.join(good)}"
