"""The whole reproduction: every experiment run, timed, judged and reported in one folder."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from components.interfaces.progress import Progress
from orchestrator.reproduction import runs, timing
from orchestrator.reproduction.paper import claims, evidence, goals
from orchestrator.reproduction.paper.evidence import Evidence
from orchestrator.reproduction.paper.experiments import Experiments, ReportFigure
from orchestrator.reproduction.paper.verdict import Verdict
from orchestrator.reproduction.report import report
from orchestrator.reproduction.varied import varied_content
from orchestrator.reproduction.varied.varied_content import JudgedSet
from orchestrator.reproduction.varied.varied_set import VariedSet
from orchestrator.results.claimed_folder import ClaimedFolder, claim
from orchestrator.results.manifest import Contents
from orchestrator.results.provenance import now
from orchestrator.sweeping.engine import workforce

EXPERIMENTS_FILE: Final = "experiments.json"
"""The list of experiments, written first."""
_RUNS: Final = "runs"
"""The folder of the run folders."""


@dataclass(frozen=True)
class Reproduced:
    """A finished reproduction."""

    folder: Path
    verdicts: tuple[Verdict, ...]


def reproduce(
    experiments: Experiments, folder: Path, progress: Progress, varied: VariedSet | None = None
) -> Reproduced:
    """Run all experiments and write the report.

    Args:
        experiments: The list of experiments.
        folder: The folder of the report, made by `new_folder`.
        progress: Receives a report at the beginning of each part of the work.
        varied: The results of the varied set, if the report is to contain them.
    """
    (folder / EXPERIMENTS_FILE).write_text(experiments.model_dump_json(indent=2) + "\n", encoding="utf-8")
    with workforce(None, None).executor() as pool:
        runs.build(experiments, progress)
        outcomes = runs.execute_all(experiments.all_runs(), folder / _RUNS, pool, progress)
        times = timing.measure(experiments.timing, outcomes, progress) if experiments.timing is not None else []
        progress.now("looking at the runs")
        gathered = evidence.gather(experiments, outcomes, times)
        progress.now("drawing the figures")
        figures = _drawn(experiments, outcomes, gathered, folder, pool)
        judged = _judged(varied, folder) if varied is not None else None
    verdicts = claims.decide(gathered)
    progress.now("writing the report")
    goal = goals.nominal(gathered)
    report.write(report.Report(experiments, outcomes, gathered, verdicts, [goal], figures, now(), judged), folder)
    return Reproduced(folder, tuple(verdicts))


def _judged(varied: VariedSet, folder: Path) -> JudgedSet:
    """The varied set with its verdicts; its figure is drawn too."""
    from orchestrator.reproduction.report import varied_figure  # noqa: PLC0415 - matplotlib is slow to import

    varied_figure.draw_varied(varied, folder / report.VARIED_FIGURE)
    return varied_content.judge(varied)


def new_folder(out: Path | None, experiments: Experiments) -> ClaimedFolder:
    """Make the folder of the report: `out`, or the next free ``runs/reproduce-1``, ``-2``, ...

    The report of a former reproduction at `out` is removed, and each run replaces its own; anything else stays.

    Raises:
        RequestError: Something else is in the way, another process writes there, or nobody can.
    """
    figures = [*map(report.figure_file, experiments.figures), report.VARIED_FIGURE]
    files = ("report.json", "report.md", "report.html", EXPERIMENTS_FILE, *figures)
    return claim("reproduce", out, Contents("reproduction", files, inner=(_RUNS,)))


def _drawn(
    experiments: Experiments,
    outcomes: dict[str, runs.Outcome],
    gathered: Evidence,
    folder: Path,
    pool: Executor,
) -> list[ReportFigure]:
    """Draw the figures in the processes that ran the experiments; those with nothing to draw are left out."""
    from orchestrator.reproduction.report import result_figures  # noqa: PLC0415 - matplotlib is slow to import

    futures = [
        (figure, pool.submit(result_figures.draw, figure, outcomes, gathered, folder / report.figure_file(figure)))
        for figure in experiments.figures
    ]
    return [figure for figure, future in futures if future.result()]
