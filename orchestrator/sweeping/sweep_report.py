"""The report of a sweep: one page that needs no other file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from orchestrator.pictures.templating import embedded, templates
from orchestrator.results.manifest import unfinished
from orchestrator.results.provenance import now, versions
from orchestrator.sweeping import findings
from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.results_table import SECONDS
from orchestrator.sweeping.sampling import VARIANT
from orchestrator.sweeping.sweep_folder import KEPT_RUNS, REPORT

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

_TEMPLATES: Final = Path(__file__).parent / "templates"
_DRAWN: Final = 8
"""What varies at most in the figure: more would be too small to see."""
_LISTED: Final = 20
"""The variants of a group that are listed."""


def write_report(  # noqa: PLR0913 - what a report is about
    planned: PlannedSweep,
    table: pd.DataFrame,
    bands: pd.DataFrame,
    kept: Mapping[int, str],
    folder: Path,
    seconds: float,
    found: Sequence[int] = (),
    mildest: int | None = None,
) -> None:
    """Write `REPORT`.

    Args:
        planned: The sweep.
        table: Its results.
        bands: The signals that are watched, over time.
        kept: The names of the run folders that were kept, by variant.
        folder: The folder of the sweep.
        seconds: The time [s] that it took.
        found: Of a search: the worst variant of each kind of failure, the worst first.
        mildest: Of a search: the failing variant that is nearest to the middle of what varies.
    """
    template = templates(_TEMPLATES).get_template("sweep.html.jinja")
    known = _content(planned, table, bands, kept)
    known |= {"aim": planned.request.find, "budget": planned.request.budget, "found": found, "mildest": mildest}
    content = template.render(**known, seconds=seconds, made=now(), versions=versions())
    with unfinished(folder / REPORT) as file:
        file.write_text(content, encoding="utf-8")


def _content(
    planned: PlannedSweep, table: pd.DataFrame, bands: pd.DataFrame, kept: Mapping[int, str]
) -> dict[str, Any]:
    metrics = findings.shown_metrics(planned.columns, table)
    indices = findings.sobol_table(planned, table)
    groups, verdicts = findings.groups(table), findings.verdict_names(table)
    failed = {number for group in groups for number in group.variants}
    return {
        "title": planned.scenario.title,
        "name": planned.scenario.name,
        "count": len(table),
        "failed": len(failed),
        "sampling": str(planned.sampling),
        "seed": planned.request.seed,
        "varied": [(v.path, v.text, _unit(planned, v.path)) for v in planned.variations],
        "shares": findings.shares(table),
        "spreads": findings.spreads(planned.columns, table),
        "units": metrics,
        "worst": [_row(planned, row, verdicts, metrics, kept) for row in _worst(planned, table)],
        "groups": [(group, group.variants[:_LISTED]) for group in groups],
        "indices": indices,
        "paths": list(planned.columns),
        "figures": _figures(planned, table, metrics, table[VARIANT].isin(list(failed))) if metrics else [],
        "over_time": _over_time(bands),
        "watched": planned.watched.in_words(len(planned)),
        "has_saltelli": planned.sampling.kind == "saltelli",
        "median_ms": 1e3 * float(table[SECONDS].median()) if len(table) else 0.0,
        "runs": KEPT_RUNS,
    }


def _worst(planned: PlannedSweep, table: pd.DataFrame) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = findings.ranked(planned.columns, table).head(findings.WORST_SHOWN).to_dict("records")  # type: ignore[assignment]
    return rows


def _row(
    planned: PlannedSweep,
    row: Mapping[str, Any],
    verdicts: Sequence[str],
    metrics: Iterable[str],
    kept: Mapping[int, str],
) -> dict[str, Any]:
    number = int(row[VARIANT])
    return {
        "number": number,
        "values": {path: row[path] for path in planned.columns},
        "metrics": {name: row[name] for name in metrics},
        "why": findings.why(row, verdicts),
        "command": findings.command(planned, number),
        "folder": kept.get(number, ""),
    }


def _figures(
    planned: PlannedSweep, table: pd.DataFrame, metrics: Mapping[str, str], failed: Any
) -> list[tuple[str, str]]:
    from orchestrator.sweeping import sweep_figures  # noqa: PLC0415 - matplotlib is slow to import

    paths = {path: _unit(planned, path) for path in list(planned.columns)[:_DRAWN]}
    logarithmic = {v.path for v in planned.variations if v.text.startswith("log:")}
    over = sweep_figures.over_values(table, metrics, paths, failed, logarithmic)
    return [
        (
            "Each metric over each value that varies; variants in red ended in a fault or fail a verdict.",
            embedded(over),
        ),
        ("How often each metric takes which values.", embedded(sweep_figures.distributions(table, metrics))),
    ]


def _over_time(bands: pd.DataFrame) -> str:
    """The picture of the signals that are watched; empty where there is none."""
    from orchestrator.sweeping import sweep_figures  # noqa: PLC0415 - as above

    return embedded(sweep_figures.over_time(bands)) if len(bands) else ""


def _unit(planned: PlannedSweep, path: str) -> str:
    unit = planned.unit(path)
    return "" if unit == "1" else unit
