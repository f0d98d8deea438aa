"""The rules of FMI that FMPy finds broken in a model description: its reports, which are texts, as data."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from components.interfaces.problem import listed

_MOST_NAMES: Final = 3
"""The most names of a set in a report."""


@dataclass(frozen=True)
class DescriptionBreach:
    """A rule of FMI that a model description breaks."""

    report: str
    """FMPy's report in one line."""
    found: str
    """The report without the line of the file."""
    line: int | None
    """The line of modelDescription.xml, where FMPy names one."""
    concerns_variability: bool
    """Whether the breach is a variability that the variable's type does not allow."""
    kind: str
    """The same text for all breaches of this rule."""
    variable: str
    """The variable that breaks it, where FMPy names one."""


def breach_of(text: str) -> DescriptionBreach:
    """A report of FMPy as data."""
    match = re.search(r" \(line (\d+)\)", text)
    variable = re.search(r"ariable \"([^\"]*)\"", text)
    text = re.sub(r"\{([^{}]*)\}", lambda names: f"{{{listed(names[1].split(', '), _MOST_NAMES)}}}", text)
    return DescriptionBreach(
        report=as_phrase(text),
        found=as_phrase(re.sub(r" \(line \d+\)", "", text, count=1)),
        line=None if match is None else int(match[1]),
        concerns_variability="must have variability" in text,
        kind=re.sub(r"\"[^\"]*\"|\(line \d+\)|\{[^{}]*\}", "", text),
        variable="" if variable is None else variable[1],
    )


def as_phrase(text: str) -> str:
    """A message of FMPy or of libxml2 as a part of one of ours: in one line, without full stop and quotation marks."""
    return " ".join(text.split()).rstrip(".").replace('"', "`")
