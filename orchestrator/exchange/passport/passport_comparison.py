"""Two passports side by side: which lines got better or worse, which figures changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Final, cast

from pydantic import BaseModel, ConfigDict

from components.interfaces.problem import refuse
from orchestrator.exchange.passport.identity import LABELS, fact_text
from orchestrator.exchange.passport.passport import SCHEMA
from orchestrator.exchange.passport.passport_line import Mark
from orchestrator.system.contents import read_json
from orchestrator.system.files import checked

_TOLD: Final = 1.1
"""The ratio of two figures from which on their difference is told."""
_VALID: Final = "the .passport.json of an FMU"


class Change(StrEnum):
    """How a line differs."""

    WORSE = "worse"
    BETTER = "better"
    OTHER = "other"


@dataclass(frozen=True)
class ChangedLine:
    """A line with another mark than before."""

    key: str
    title: str
    before: str
    after: str
    change: Change
    evidence: str


@dataclass(frozen=True)
class PassportComparison:
    """What has changed from one passport to another."""

    file: str
    """The FMU of the other passport."""
    made: str
    lines: tuple[ChangedLine, ...]
    figures: tuple[tuple[str, str, str, str], ...]
    """Line, name of the figure, and both values with their unit, where they differ by more than a tenth."""
    facts: tuple[tuple[str, str, str], ...]
    """Label, and both texts."""

    @property
    def good(self) -> bool:
        """Whether no line got worse."""
        return all(line.change is not Change.WORSE for line in self.lines)

    def data(self) -> dict[str, Any]:
        """The comparison as plain data."""
        return {
            "file": self.file,
            "made": self.made,
            "good": self.good,
            "lines": [
                {"key": c.key, "before": c.before, "after": c.after, "change": c.change.value} for c in self.lines
            ],
            "figures": [{"line": k, "name": n, "before": b, "after": a} for k, n, b, a in self.figures],
            "identity": [{"label": n, "before": b, "after": a} for n, b, a in self.facts],
        }


class _Part(BaseModel):
    model_config = ConfigDict(strict=True)


class _Figure(_Part):
    value: float
    unit: str


class _KeptLine(_Part):
    key: str
    title: str
    mark: str
    evidence: str
    figures: dict[str, _Figure]


class _Identity(_Part):
    default_experiment: dict[str, float | None] | None = None
    variables: dict[str, int] | None = None
    size: int | None = None


class _Provenance(_Part):
    made: str | None = None


class _KeptPassport(_Part):
    """What is read of a passport; other entries may be anything."""

    file: str
    lines: list[_KeptLine]
    identity: _Identity
    provenance: _Provenance = _Provenance()


def read_passport(path: Path) -> dict[str, Any]:
    """The JSON of a passport. Raises `RequestError`."""
    where = f"--against {path}"
    content: Any = read_json(path, where, _VALID)
    if not isinstance(content, dict) or not {"schema", "lines", "identity", "file"} <= content.keys():
        raise refuse(where, "another JSON", _VALID)
    if content["schema"] != SCHEMA:
        raise refuse(where, f"schema {content['schema']}", f"schema {SCHEMA}", "Make it again.")
    checked(_KeptPassport, cast("dict[str, Any]", content), where)
    return cast("dict[str, Any]", content)


def compared_with(before: Mapping[str, Any], after: Mapping[str, Any]) -> PassportComparison:
    """Compare two passports, given as their plain data.

    A line is worse if it fails and did not fail before, and better if it failed and does not fail any more.
    """
    old, new = ({line["key"]: line for line in content["lines"]} for content in (before, after))
    changed: list[ChangedLine] = []
    for key in dict.fromkeys((*new, *old)):
        one, other = (lines[key]["mark"] if key in lines else "not there" for lines in (old, new))
        if one != other:
            line = new.get(key) or old[key]
            evidence = new[key]["evidence"] if key in new else ""
            changed.append(ChangedLine(key, line["title"], one, other, _change(one, other), evidence))
    order = list(Change)
    changed.sort(key=lambda line: order.index(line.change))
    return PassportComparison(
        file=str(before["file"]),
        made=str(before.get("provenance", {}).get("made", "")),
        lines=tuple(changed),
        figures=tuple(_figures(old, new)),
        facts=tuple(_facts(before["identity"], after["identity"])),
    )


def _change(before: str, after: str) -> Change:
    if after == Mark.FAILS:
        return Change.WORSE
    return Change.BETTER if before == Mark.FAILS else Change.OTHER


def _figures(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    found: list[tuple[str, str, str, str]] = []
    for key, line in new.items():
        before = old.get(key, {}).get("figures", {})
        for name, figure in line["figures"].items():
            if name in before and _differ(before[name]["value"], figure["value"]):
                found.append((key, name, figure_text(before[name]), figure_text(figure)))
    return found


def figure_text(figure: Mapping[str, Any]) -> str:
    """A figure with its unit."""
    return f"{figure['value']:.3g}{'' if figure['unit'] == '1' else ' ' + figure['unit']}"


def _differ(one: float, other: float) -> bool:
    small, large = sorted((abs(one), abs(other)))
    return one * other < 0 or large > _TOLD * small


def _facts(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    pairs = [(label, fact_text(key, old.get(key)), fact_text(key, new.get(key))) for key, label in LABELS.items()]
    return [(label, before or "not told", after or "not told") for label, before, after in pairs if before != after]
