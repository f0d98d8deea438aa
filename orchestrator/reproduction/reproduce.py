"""The whole reproduction: every experiment run, timed, judged and reported in one folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import refuse
from orchestrator.reproduction import runs, timing
from orchestrator.reproduction.paper import claims, evidence, goals
from orchestrator.reproduction.paper.experiments import Experiments
from orchestrator.reproduction.paper.verdict import Verdict
from orchestrator.reproduction.report import report
from orchestrator.reproduction.varied import varied_content
from orchestrator.reproduction.varied.varied_set import VariedSet

LIST: Final = "experiments.json"
"""The list of experiments, written first: a folder that has it holds a reproduction, whole or cut short."""


@dataclass(frozen=True)
class Reproduced:
    """What the reproduction left behind."""

    folder: Path
    verdicts: tuple[Verdict, ...]


def reproduce(
    wanted: Experiments, folder: Path, progress: Callable[[str], None], varied: VariedSet | None = None
) -> Reproduced:
    """Run all experiments and write the report into a `new_folder`, with a varied set where there is one."""
    (folder / LIST).write_text(wanted.model_dump_json(indent=2) + "\n", encoding="utf-8")
    with runs.processes() as pool:
        runs.build(wanted, progress)
        outcomes = runs.execute_all(wanted.all_runs(), folder / "runs", pool, progress)
        times = timing.measure(wanted.timing, outcomes, progress) if wanted.timing is not None else []
        progress("looking at the runs")
        found = evidence.gather(wanted, outcomes, times)
        progress("drawing the figures")
        drawn = _drawn(wanted, outcomes, found, folder, pool)
        told = _varied(varied, folder)
    verdicts = claims.decide(found)
    progress("writing the report")
    report.write(report.Report(wanted, outcomes, found, verdicts, [goals.nominal(found)], drawn, told), folder)
    return Reproduced(folder, tuple(verdicts))


def _varied(varied: VariedSet | None, folder: Path) -> dict[str, Any] | None:
    """What the report tells of a varied set, with its figure."""
    if varied is None:
        return None
    from orchestrator.reproduction.varied import varied_plots  # noqa: PLC0415 - matplotlib takes its time

    told = varied_content.content(varied)
    varied_plots.draw(told, folder / "figures" / "varied.png")
    return {**told, "figure": "figures/varied.png"}


def new_folder(out: Path | None) -> Path:
    """The folder of the report: `out`, or the next free ``runs/reproduce-1``, ``-2``, ...

    A former reproduction at `out` is replaced; anything else that is there stays. Raises `RequestError`.
    """
    folder = out
    if folder is None:
        taken = [int(n) for p in Path("runs").glob("reproduce-*") if (n := p.name.rpartition("-")[2]).isdigit()]
        folder = Path("runs") / f"reproduce-{max(taken, default=0) + 1}"
    valid = "a folder that is new, empty or a former reproduction, in a place that can be written to"
    if folder.is_file() or (folder.is_dir() and any(folder.iterdir()) and not (folder / LIST).is_file()):
        found = "a file" if folder.is_file() else "a folder with other things in it"
        raise refuse(str(folder), found, valid, "Choose another folder with --out.")
    try:
        if folder.is_dir():
            shutil.rmtree(folder)
        folder.mkdir(parents=True)
    except OSError as error:
        found = f"a folder that cannot be written to ({error.strerror})"
        raise refuse(str(folder), found, valid, "Choose another one.") from error
    return folder


def _drawn(
    wanted: Experiments,
    outcomes: dict[str, runs.Outcome],
    found: evidence.Evidence,
    folder: Path,
    pool: ProcessPoolExecutor,
) -> list[tuple[str, str]]:
    """The figures, drawn by the processes that ran the experiments; file name and caption of each."""
    from orchestrator.reproduction.report import result_figures  # noqa: PLC0415 - matplotlib takes its time

    futures = [
        (p, pool.submit(result_figures.draw, p, outcomes, found, folder / "figures" / f"{p.name}.png"))
        for p in wanted.figures
    ]
    return [(picture.name, picture.caption) for picture, future in futures if future.result()]
