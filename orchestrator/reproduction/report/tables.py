"""Tables of the report as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from orchestrator.reproduction.report.metric_names import number, title


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table; nothing without rows."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(["| " + " | ".join(head) + " |", "|" + " --- |" * len(head), *lines]) if lines else ""


def verdict_table(verdicts: Sequence[Mapping[str, Any]]) -> str:
    """One line for each claim."""
    rows = (
        [v["claim"], v["words"], f"**{v['verdict']}**", v["condition"], "; ".join(v["cannot_be_compared"])]
        for v in verdicts
    )
    return table(("", "claim", "verdict", "condition", "cannot be compared"), rows)


def details(
    verdict: Mapping[str, Any], runs: Mapping[str, Mapping[str, Any]], timed: Sequence[Mapping[str, float]]
) -> Iterator[str]:
    """The cases of a verdict, with the numbers that decide and the runs they come from."""
    yield f"### {verdict['claim']}: {verdict['words']}"
    told = f", {verdict['condition']}" if verdict["condition"] else ""
    yield f"**{verdict['verdict'].capitalize()}**{told}. A case holds with: {verdict['decided_by']}."
    rows: list[list[str]] = []
    for i, case in enumerate(verdict["cases"]):
        numbers = {**case["numbers"], **(timed[i] if i < len(timed) else {})}
        values = "; ".join(f"{title(name)}: {number(value)}" for name, value in numbers.items())
        says = {True: "yes", False: "no", None: "cannot be compared"}[case["holds"]]
        links = ", ".join(run_link(runs[name]) for name in case["runs"])
        rows.append([", ".join(case["factors"].values()), says, values, case["note"], links])
    yield table(("case", "holds", "numbers", "", "runs"), rows)
    yield from verdict["notes"]


def run_link(run: Mapping[str, Any]) -> str:
    """A run by its name, leading to its folder."""
    return f"[{run['name']}]({run['folder']}/)"
