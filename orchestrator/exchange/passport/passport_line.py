"""The lines of a passport: each passes, fails, or does not apply, and says on what evidence."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType
from typing import Any, Final, NamedTuple, TypeAlias

from components.interfaces.problem import listed


class Mark(StrEnum):
    """What became of a line."""

    PASSES = "passes"
    FAILS = "fails"
    NOT_APPLICABLE = "does not apply"


class Measured(NamedTuple):
    """A figure with its unit of measurement."""

    value: float
    unit: str


Figures: TypeAlias = Mapping[str, Measured]
"""Figures by their stable names."""
NO_FIGURES: Final[Figures] = MappingProxyType({})


@dataclass(frozen=True)
class Line:
    """One line of a passport."""

    key: str
    """Its stable name, `GROUP.NAME`."""
    title: str
    """What is asked of the FMU, as a statement."""
    mark: Mark
    evidence: str
    """What was found, in a sentence."""
    figures: Figures = field(default_factory=dict[str, Measured])
    details: tuple[str, ...] = ()
    """All findings, where the evidence can only count them."""

    @property
    def group(self) -> str:
        """The group that it belongs to."""
        return self.key.partition(".")[0]

    def data(self) -> dict[str, Any]:
        """The line as plain data."""
        return {
            "key": self.key,
            "group": self.group,
            "title": self.title,
            "mark": self.mark.value,
            "evidence": self.evidence,
            "figures": {name: {"value": m.value, "unit": m.unit} for name, m in self.figures.items()},
            "details": list(self.details),
        }


class Topic(NamedTuple):
    """What a line is about; its methods make the line."""

    key: str
    title: str

    def passes(self, evidence: str, figures: Figures = NO_FIGURES, details: Sequence[str] = ()) -> Line:
        """The line of an FMU that does what is asked of it."""
        return Line(self.key, self.title, Mark.PASSES, evidence, figures, tuple(details))

    def fails(self, evidence: str, figures: Figures = NO_FIGURES, details: Sequence[str] = ()) -> Line:
        """The line of an FMU that does not."""
        return Line(self.key, self.title, Mark.FAILS, evidence, figures, tuple(details))

    def does_not_apply(self, why: str) -> Line:
        """The line of an FMU of which this cannot be asked."""
        return Line(self.key, self.title, Mark.NOT_APPLICABLE, why)

    def judged(self, findings: Sequence[str], fine: str, figures: Figures = NO_FIGURES) -> Line:
        """The line of a search for faults: it fails with what was found, or passes with the text for none."""
        if not findings:
            return self.passes(fine, figures)
        return self.fails(enumerated(findings), figures, findings if len(findings) > SHOWN else ())


GROUPS: Final[Mapping[str, str]] = {
    "rules": "Rules of FMI",
    "library": "Library",
    "determinism": "Determinism",
    "state": "Reset and state",
    "instances": "Several instances",
    "feedthrough": "Feedthrough",
    "dynamics": "Step size",
    "declared": "Limits, units and start values",
    "cost": "Cost",
    "faults": "Behaviour at its limits",
    "fit": "Sockets",
    "drive": "A drive",
    "smoke": "Tests that it carries",
}
"""The groups of lines in the order of the page, with their headings."""

SHOWN: Final = 3
"""The number of findings that the evidence of a line names."""


def enumerated(findings: Sequence[str]) -> str:
    """The first findings as one phrase, with the number of the others."""
    more = len(findings) - SHOWN
    return "; ".join(findings[:SHOWN]) + (f"; and {more} more" if more > 0 else "")


def named(names: Iterable[str]) -> str:
    """Names of variables as one phrase."""
    return listed([f"`{name}`" for name in names], SHOWN)
