"""The whole reproduction: every experiment run, timed, judged and reported in one folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from components.interfaces.problem import refuse
from orchestrator.reproduction import claims, evidence, experiments, goals, report, runs, timing
from orchestrator.reproduction.verdict import Verdict

LIST: Final = "experiments.toml"
"""The list of experiments, kept beside what came of it."""


@dataclass(frozen=True)
class Reproduced:
    """What the reproduction left behind."""

    folder: Path
    verdicts: tuple[Verdict, ...]


def reproduce(out: Path | None, progress: Callable[[str], None], listed: Path = experiments.EXPERIMENTS) -> Reproduced:
    """Run all experiments of a list and write the report. Raises `RequestError` for a wrong request."""
    wanted = experiments.load(listed)
    folder = new_folder(out)
    shutil.copyfile(listed, folder / LIST)
    with runs.processes() as pool:
        runs.build(wanted, progress)
        outcomes = runs.execute_all(wanted.all_runs(), folder / "runs", pool, progress)
        times = timing.measure(wanted.timing, outcomes, progress) if wanted.timing is not None else []
        progress("looking at the runs")
        found = evidence.gather(wanted, outcomes, times)
        drawn = _drawn(wanted, outcomes, found, folder, pool)
    verdicts = claims.decide(found)
    progress("writing the report")
    report.write(report.Report(wanted, outcomes, found, verdicts, [goals.nominal(found)], drawn), folder)
    return Reproduced(folder, tuple(verdicts))


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
    wanted: experiments.Experiments,
    outcomes: dict[str, runs.Outcome],
    found: evidence.Evidence,
    folder: Path,
    pool: ProcessPoolExecutor,
) -> list[tuple[str, str]]:
    """The figures, drawn by the processes that ran the experiments; file name and caption of each."""
    from orchestrator.reproduction import plots  # noqa: PLC0415 - matplotlib takes its time

    futures = [
        (p, pool.submit(plots.draw, p, outcomes, found, folder / "figures" / f"{p.name}.png")) for p in wanted.figures
    ]
    return [(picture.name, picture.caption) for picture, future in futures if future.result()]
