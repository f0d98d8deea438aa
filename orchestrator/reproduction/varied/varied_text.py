"""The varied set in the report, from its content as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from orchestrator.reproduction.report.metric_names import COLUMNS, number
from orchestrator.reproduction.report.tables import details, table, verdict_table

_MOST_LISTED: Final = 20
"""Cases that `mpc_plus` does not come through, listed with their commands; the others stand in `report.json`."""


def varied_section(varied: Mapping[str, Any]) -> Iterator[str]:
    """Ranges, distributions and verdicts."""
    yield f"## {varied['count']} variations of seed {varied['seed']}"
    yield (
        f"Every controller drives every case on `{varied['plant']}`: the tyre saturates. No recordings; `report.json` "
        "has each case's values, metrics and the command that runs it again."
    )
    yield verdict_table(varied["claims"] + varied["goals"])
    yield f"![Distributions over the variations.]({varied['figure']})" if varied.get("figure") else ""
    yield "### Ranges"
    yield table(("task", "", "from", "to", "unit", ""), _ranges(varied["ranges"]))
    yield "### Distributions"
    yield "Shares of the cases; 5th, 50th and 95th percentile of the metrics."
    first = varied["controllers"][0].get("spread", {})
    head = (
        "controller",
        "cases",
        "no contact",
        "inside road",
        "both",
        "a solve at its limit",
        "a failed solve",
        "faults",
    )
    yield table((*head, *(COLUMNS[name] for name in first)), _distributions(varied))
    yield "### What decides each verdict on the variations"
    for verdict in varied["claims"] + varied["goals"]:
        yield from details(verdict, {}, ())
    yield from _unresolved(varied)


def _ranges(ranges: Mapping[str, Mapping[str, Any]]) -> Iterator[list[str]]:
    for task, drawn in ranges.items():
        for name, r in drawn.items():
            what = f"{r['what']}" + (f" ({r['count']} values)" if r["count"] > 1 else "")
            yield [task, f"`{name}`", f"{r['low']:g}", f"{r['high']:g}", r["unit"], what]


def _distributions(varied: Mapping[str, Any]) -> Iterator[list[str]]:
    for c in varied["controllers"]:
        if not c["cases"]:
            continue
        shares = [f"{c[name]:.1%}" for name in ("no_contact", "inside_road", "both", "solver_limit", "solver_failure")]
        spread = [" / ".join(number(value) for value in values.values()) for values in c["spread"].values()]
        yield [c["label"], str(c["cases"]), *shares, str(c["faults"]), *spread]


def _unresolved(varied: Mapping[str, Any]) -> Iterator[str]:
    numbers = varied["unresolved"]
    yield "### Cases that mpc-plus does not come through"
    if not numbers:
        yield "None."
        return
    yield f"{len(numbers)} of {varied['count']}: {', '.join(map(str, numbers))}."
    cases = {case["number"]: case for case in varied["cases"]}
    for n in numbers[:_MOST_LISTED]:
        yield f"{n}: `{cases[n]['runs']['mpc-plus']['command']}`"
