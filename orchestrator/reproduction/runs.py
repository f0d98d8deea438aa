"""The runs of the reproduction, each with a run folder of its own, on all cores."""

from __future__ import annotations

import json
import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from components import BLOCKS
from fmus.toolchain.version import Version
from orchestrator import run as runner
from orchestrator.recording.recording import Afterwards
from orchestrator.reproduction.paper.experiments import Experiments, Role, Run
from orchestrator.results.summary import SUMMARY
from orchestrator.scenario import catalogue, prepare, scenario_file
from orchestrator.scenario.options import Options

MODE: Final = Version.FMI3
"""How native blocks run; the others run in the process of the run."""

_MOST_PROCESSES: Final = 8


@dataclass(frozen=True)
class Outcome:
    """A run and what is told of it in its folder."""

    run: Run
    folder: Path
    remarks: tuple[str, ...]

    @property
    def summary(self) -> dict[str, Any]:
        """What stands in the folder's `summary.json`."""
        return json.loads((self.folder / SUMMARY).read_text("utf-8"))


def options(run: Run) -> Options:
    """What `macrostep run` would be told."""
    return Options(
        mode=MODE, replacements={"plant": run.plant, "controller": run.controller}, settings=list(run.settings)
    )


def command(run: Run) -> str:
    """The command that does the same run."""
    settings = "".join(f" --set {setting}" for setting in run.settings)
    return f"macrostep run {run.scenario} --plant {run.plant} --controller {run.controller}{settings}"


def processes() -> ProcessPoolExecutor:
    """A process for each core, started afresh: a forked one would share locks with this one's threads."""
    count = min(os.cpu_count() or 1, _MOST_PROCESSES)
    return ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))


def build(experiments: Experiments, progress: Callable[[str], None]) -> None:
    """Build every FMU that is needed, before several processes ask for the same one."""
    names = {name for run in experiments.runs for name in (run.plant, run.controller)}
    names |= {name for sweep in experiments.sweeps for name in (sweep.plant, sweep.controller)}
    for run in experiments.all_runs():
        content = scenario_file.read(run.scenario)[1]
        names |= {block} if (block := content.units["traffic"].block) else set()
    if experiments.timing is not None:
        names |= set(experiments.timing.controllers)
    build_blocks(names, progress)


def build_blocks(names: set[str], progress: Callable[[str], None]) -> None:
    """Build the FMUs of those of these blocks that are native."""
    native = [BLOCKS[name] for name in sorted(names) if BLOCKS[name].native]
    catalogue.ensure_built(native, [MODE], catalogue.built_folder(), progress)


def execute(run: Run, folder: Path) -> Outcome:
    """One run with its folder; those of a sweep without figures."""
    made = prepare.prepare(run.scenario, options(run))
    beside = runner.Beside(Afterwards(), figures=run.role is not Role.SWEEP)
    told = runner.execute(made, folder, lambda _: None, beside).summary
    figures = (f"figures {told['figures']}",) if "figures" in told else ()
    return Outcome(run, folder, made.remarks + figures)


def execute_all(
    runs: Sequence[Run], folder: Path, pool: ProcessPoolExecutor, progress: Callable[[str], None]
) -> dict[str, Outcome]:
    """All runs, in `folder/NAME`; slow ones first, so that no core waits for the last."""
    order = sorted(runs, key=lambda run: BLOCKS[run.controller].native)
    futures = [pool.submit(execute, run, folder / run.name) for run in order]
    found: dict[str, Outcome] = {}
    for future in as_completed(futures):
        outcome = future.result()
        found[outcome.run.name] = outcome
        progress(f"run {len(found)} of {len(runs)}: {outcome.run.name}")
    return {run.name: found[run.name] for run in runs}
