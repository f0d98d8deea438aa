"""Verdicts: a claim is examined in cases, and holds in all of them, in some, or in none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from orchestrator.reproduction.paper import where
from orchestrator.reproduction.paper.where import counted

TIME_METRIC: Final = "p50_us"
"""The one metric among those that decide claims which is a wall time: it differs from one reproduction to the next."""

FAULT_NOTE: Final = "a run ended in a fault"

_ALL: Final = {1: "the one case", 2: "both cases"}
_ANY: Final = {1: "the one case", 2: "either case"}
"""Numbers of cases that are words."""


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
    against: tuple[str, ...] = ()
    """The metrics that speak against the claim, where it does not hold."""

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
    def title(self) -> str:
        """The heading of what is told about it."""
        return f"{self.claim}: {self.words}"

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
        """Where it holds, or where it does not if that is shorter; empty where there is no condition."""
        if self.status is not Status.CONDITION:
            return ""
        good, bad = ([case.factors for case in self.cases if case.holds is wanted] for wanted in (True, False))
        holding, failing = where.groups(good, bad), where.groups(bad, good)
        shorter = len(failing) < len(holding)
        return f"except {where.in_words(failing)}" if shorter else where.in_words(holding)

    @property
    def outcome(self) -> str:
        """The outcome in whole words: `holds against LQR and Stanley on linear tyres (3 of 8 cases)`."""
        decided = [case.holds for case in self.cases if case.holds is not None]
        n, left = len(decided), len(self.cases) - len(decided)
        rest = f"; {left} more cannot be compared" if left else ""
        match self.status:
            case Status.HOLDS:
                return f"holds in {_ALL.get(n, f'all {n} cases')}{rest}"
            case Status.FAILS:
                return f"does not hold in {_ANY.get(n, f'any of the {n} cases')}{rest}"
            case Status.CONDITION:
                return f"holds {self.condition} ({sum(decided)} of {counted(n)}{rest})"
            case Status.OPEN:
                return f"not decided: {counted(left)} that cannot be compared" if left else "not decided: no case"

    @property
    def open_cases(self) -> tuple[str, ...]:
        """The cases that are not decided."""
        return tuple(str(case) for case in self.cases if case.holds is None)

    @property
    def speaking_against(self) -> dict[str, int]:
        """In how many of the cases each metric speaks against the claim."""
        return dict(Counter(metric for case in self.cases for metric in case.against))


def unmet(met: Mapping[str, bool]) -> tuple[str, ...]:
    """The metrics whose condition is not met."""
    return tuple(name for name, is_met in met.items() if not is_met)


def verdict_data(verdict: Verdict) -> dict[str, Any]:
    """A verdict as plain data, without wall times: these stand in a section of their own."""
    return {
        "claim": verdict.claim,
        "words": verdict.words,
        "verdict": verdict.status.value,
        "condition": verdict.condition,
        "outcome": verdict.outcome,
        "cannot_be_compared": list(verdict.open_cases),
        "decided_by": verdict.decided_by,
        "cases": [
            {
                "factors": dict(case.factors),
                "holds": case.holds,
                "numbers": {number.name: number.value for number in case.measured if not number.is_time},
                "runs": list(case.runs),
                "note": case.note,
                "speaks_against": list(case.against),
            }
            for case in verdict.cases
        ],
        "notes": list(verdict.notes),
    }


def time_data(verdict: Verdict) -> list[dict[str, float]]:
    """The wall times of a verdict, case by case; empty where no case has any."""
    times = [{number.name: number.value for number in case.measured if number.is_time} for case in verdict.cases]
    return times if any(times) else []
