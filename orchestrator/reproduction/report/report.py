"""The report: one content, written for a machine (JSON), for a text reader (Markdown) and for a browser (HTML)."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from markdown_it import MarkdownIt

from orchestrator.reproduction.paper.evidence import Evidence, Result
from orchestrator.reproduction.paper.experiments import Experiments
from orchestrator.reproduction.paper.verdict import Verdict, verdict_data
from orchestrator.reproduction.report.text import markdown
from orchestrator.reproduction.runs import Outcome, command
from orchestrator.results.provenance import versions

TEMPLATE: Final = Path(__file__).parent / "report.template.html"
_IMAGE: Final = re.compile(r'<img src="(?P<path>[^":]+)"')
_TIMED: Final = "p50_us"


@dataclass(frozen=True)
class Report:
    """All that is told."""

    experiments: Experiments
    outcomes: Mapping[str, Outcome]
    evidence: Evidence
    verdicts: Sequence[Verdict]
    goals: Sequence[Verdict]
    figures: Sequence[tuple[str, str]]
    """File name and caption"""
    varied: Mapping[str, Any] | None = None


def write(report: Report, folder: Path) -> None:
    """Write `report.json`, `report.md` and `report.html`, the JSON last: a folder without it is not whole."""
    told = content(report, folder)
    text = markdown(told)
    (folder / "report.md").write_text(text, encoding="utf-8")
    (folder / "report.html").write_text(html(text, folder), encoding="utf-8")
    (folder / "report.json").write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")


def content(report: Report, folder: Path) -> dict[str, Any]:
    """Everything as plain data. All but `timings` is the same in every reproduction with the same versions."""
    results = {r.name: r for r in report.evidence.results}
    results |= {r.name: r for curve in report.evidence.curves for r in curve.points}
    told: dict[str, Any] = {
        "runs": [_run(report.outcomes[name], r, folder) for name, r in results.items()],
        "sweeps": [
            {"name": c.name, "label": c.label, "plant": c.plant, "runs": [p.name for p in c.points]}
            for c in report.evidence.curves
        ],
        "claims": [verdict_data(v, without=_TIMED) for v in report.verdicts],
        "goals": [verdict_data(v) for v in report.goals],
        "distances": dict(report.evidence.distances),
        "off_path": dict(report.evidence.off_path),
        "figures": [{"file": f"figures/{name}.png", "caption": caption} for name, caption in report.figures],
        "varied": report.varied,
        "versions": versions(),
        "timings": {
            "ratio_to": report.experiments.timing.ratio_to if report.experiments.timing is not None else None,
            "states": report.experiments.timing.states if report.experiments.timing is not None else None,
            "controllers": [asdict(t) for t in report.evidence.timings],
            "claims": {v.claim: [_timed(case.numbers) for case in v.cases] for v in report.verdicts if _is_timed(v)},
        },
    }
    return told


def _run(outcome: Outcome, result: Result, folder: Path) -> dict[str, Any]:
    told, run = outcome.summary, outcome.run
    where = outcome.folder.relative_to(folder).as_posix()
    return {
        **{name: getattr(run, name) for name in ("name", "label", "task", "scenario", "plant", "controller")},
        "role": run.role.value,
        "settings": list(run.settings),
        "command": command(run),
        "folder": where,
        "recording": f"{where}/recording.rrd",
        "status": told["status"],
        "fault": told.get("fault"),
        "metrics": dict(result.metrics),
        "verdicts": told["verdicts"],
        "remarks": list(outcome.remarks),
    }


def _is_timed(verdict: Verdict) -> bool:
    return any(_timed(case.numbers) for case in verdict.cases)


def _timed(numbers: Mapping[str, float]) -> dict[str, float]:
    return {name: value for name, value in numbers.items() if name.startswith(_TIMED)}


def html(text: str, folder: Path) -> str:
    """The Markdown as one page that needs nothing else: figures stand inside it."""
    body = MarkdownIt("commonmark").enable("table").render(text)
    body = body.replace("<table>", '<div class="wide"><table>').replace("</table>", "</table></div>")

    def inlined(match: re.Match[str]) -> str:
        data = base64.b64encode((folder / match["path"]).read_bytes()).decode("ascii")
        return f'<img src="data:image/png;base64,{data}"'

    return TEMPLATE.read_text("utf-8").replace("{{body}}", _IMAGE.sub(inlined, body))
