"""Verdicts: a claim is looked at in cases, and holds in all of them, in some, or in none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Status(StrEnum):
    """What becomes of a claim."""

    HOLDS = "holds"
    CONDITION = "holds under a condition"
    FAILS = "does not hold"
    OPEN = "not decided"


@dataclass(frozen=True)
class Case:
    """One comparison that a claim rests on."""

    factors: Mapping[str, str]
    """What was compared: setting, baseline, tyre, ..."""
    holds: bool | None
    """None where the numbers do not say"""
    numbers: Mapping[str, float]
    runs: tuple[str, ...]
    note: str = ""

    def __str__(self) -> str:
        return ", ".join(self.factors.values())


@dataclass(frozen=True)
class Verdict:
    """A claim of the paper, and what the cases say about it."""

    claim: str
    words: str
    decided_by: str
    cases: tuple[Case, ...]
    notes: tuple[str, ...] = ()

    @property
    def status(self) -> Status:
        """Holds in all cases that say something, in some, or in none."""
        said = [case.holds for case in self.cases if case.holds is not None]
        if not said:
            return Status.OPEN
        if all(said):
            return Status.HOLDS
        return Status.CONDITION if any(said) else Status.FAILS

    @property
    def condition(self) -> str:
        """Under which condition it holds, as short as the cases allow; empty where there is none."""
        if self.status is not Status.CONDITION:
            return ""
        return condition([case for case in self.cases if case.holds is not None])

    @property
    def open_cases(self) -> tuple[str, ...]:
        """The cases in which the numbers do not say."""
        return tuple(str(case) for case in self.cases if case.holds is None)


def verdict_data(verdict: Verdict, without: str = "\0") -> dict[str, Any]:
    """A verdict as plain data; numbers whose names start with `without` are left to another place."""
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
                "numbers": {n: v for n, v in case.numbers.items() if not n.startswith(without)},
                "runs": list(case.runs),
                "note": case.note,
            }
            for case in verdict.cases
        ],
        "notes": list(verdict.notes),
    }


def condition(cases: Sequence[Case]) -> str:
    """What the cases in which a claim holds have in common, in terms of the factors that matter."""
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
    """The combinations of some factors in which it holds, and does not; empty where these do not explain it."""
    seen: dict[str, set[bool]] = {}
    for case in cases:
        combination = " / ".join(f"{name} {case.factors[name]}" for name in names if name in case.factors)
        seen.setdefault(combination or "otherwise", set()).add(bool(case.holds))
    if any(len(values) > 1 for values in seen.values()):
        return ""
    good = [text for text, values in seen.items() if values == {True}]
    bad = [text for text, values in seen.items() if values == {False}]
    return f"except for {'; '.join(bad)}" if len(bad) < len(good) else f"only for {'; '.join(good)}"
