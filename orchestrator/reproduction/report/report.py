"""The report: one content, written for a machine (JSON), for a text reader (Markdown) and for a browser (HTML)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from orchestrator.reproduction.paper.evidence import Evidence, Result
from orchestrator.reproduction.paper.experiments import Experiments, ReportFigure
from orchestrator.reproduction.paper.verdict import Verdict, time_data, verdict_data
from orchestrator.reproduction.report.rendering import html, markdown
from orchestrator.reproduction.runs import Outcome, command
from orchestrator.reproduction.varied import varied_content
from orchestrator.reproduction.varied.varied_content import JudgedSet
from orchestrator.results.provenance import versions
from orchestrator.results.run_folder import RECORDING

REPORT_FIGURES: Final = "figures"
"""The folder of the figures inside that of the report."""

VARIED_FIGURE: Final = f"{REPORT_FIGURES}/varied.png"


@dataclass(frozen=True)
class Report:
    """Everything that the report contains."""

    experiments: Experiments
    outcomes: Mapping[str, Outcome]
    """The outcomes by the name of the run."""
    evidence: Evidence
    verdicts: Sequence[Verdict]
    """The verdicts on the claims of the paper."""
    goals: Sequence[Verdict]
    figures: Sequence[ReportFigure]
    """The figures that were drawn."""
    made: str
    """When it was made, as `provenance.now` says it."""
    varied: JudgedSet | None = None


def figure_file(figure: ReportFigure) -> str:
    """The file of a figure, relative to the folder of the report."""
    return f"{REPORT_FIGURES}/{figure.name}.png"


def write(report: Report, folder: Path) -> None:
    """Write `report.json`, `report.md` and `report.html`, the JSON last: a folder without it is incomplete."""
    data = content(report, folder)
    varied = report.varied
    verdicts = {"claims": report.verdicts, "goals": report.goals}
    text = markdown(data, verdicts | ({"varied": varied.claims + varied.goals} if varied is not None else {}))
    (folder / "report.md").write_text(text, encoding="utf-8")
    (folder / "report.html").write_text(html(text, folder), encoding="utf-8")
    (folder / "report.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")


def content(report: Report, folder: Path) -> dict[str, Any]:
    """The report as plain data.

    With the same versions, all but `made`, `timings` and what these decide is the same in every reproduction.

    Args:
        report: The report.
        folder: Its folder, to which the folders of the runs are relative.
    """
    results = {r.name: r for r in report.evidence.results}
    results |= {r.name: r for curve in report.evidence.curves for r in curve.points}
    varied = report.varied
    return {
        "made": report.made,
        "versions": versions(),
        "runs": [_run(report.outcomes[name], r, folder) for name, r in results.items()],
        "sweeps": [
            {"name": c.name, "label": c.label, "plant": c.plant, "runs": [p.name for p in c.points]}
            for c in report.evidence.curves
        ],
        "claims": [verdict_data(v) for v in report.verdicts],
        "goals": [verdict_data(v) for v in report.goals],
        "distances": dict(report.evidence.distances),
        "off_path": dict(report.evidence.off_path),
        "figures": [
            {"file": figure_file(figure), "caption": figure.caption, "claims": list(figure.claims)}
            for figure in report.figures
        ],
        "varied": None if varied is None else {**varied_content.content(varied), "figure": VARIED_FIGURE},
        "timings": _timings(report),
    }


def _timings(report: Report) -> dict[str, Any]:
    plan = report.experiments.timing
    return {
        "ratio_to": plan.ratio_to if plan is not None else None,
        "states": plan.states if plan is not None else None,
        "controllers": [asdict(timing) for timing in report.evidence.timings],
        "claims": {v.claim: times for v in report.verdicts if (times := time_data(v))},
    }


def _run(outcome: Outcome, result: Result, folder: Path) -> dict[str, Any]:
    summary, run = outcome.summary, outcome.run
    run_folder = outcome.folder.relative_to(folder).as_posix()
    return {
        **{name: getattr(run, name) for name in ("name", "label", "task", "scenario", "plant", "controller")},
        "role": run.role.value,
        "settings": list(run.settings),
        "command": command(run),
        "folder": run_folder,
        "recording": f"{run_folder}/{RECORDING}",
        "status": summary["status"],
        "fault": summary.get("fault"),
        "metrics": dict(result.metrics),
        "verdicts": summary["verdicts"],
        "remarks": list(outcome.remarks),
    }
