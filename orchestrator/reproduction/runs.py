"""The runs of the reproduction, each with a run folder of its own, on all cores."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd

from components import BLOCKS
from components.interfaces.progress import SILENT, Progress
from components.interfaces.sockets import CONTROLLER, PLANT
from fmus.toolchain.version import Version
from orchestrator import execution as runner
from orchestrator.recording.recording import Afterwards
from orchestrator.reproduction.paper.experiments import Experiments, RunPlan, RunRole
from orchestrator.results.run_folder import SIGNALS, SUMMARY
from orchestrator.scenario import catalogue, prepare, scenario_file
from orchestrator.scenario.options import Options
from orchestrator.system.shown import BusPaths, shown

MODE: Final = Version.FMI3
"""How native blocks run; blocks that are not native run inside the process of the run."""

_REPLACED: Final = (PLANT.name, CONTROLLER.name)
"""The sockets of a scenario that each run fills with blocks of its own."""


@dataclass(frozen=True)
class Outcome:
    """An executed run and its folder."""

    run: RunPlan
    folder: Path
    buses: BusPaths
    """The buses of the system that was run."""
    remarks: tuple[str, ...]

    @property
    def summary(self) -> dict[str, Any]:
        """The content of the folder's `summary.json`."""
        return json.loads((self.folder / SUMMARY).read_text("utf-8"))

    def rows(self) -> pd.DataFrame:
        """Read the rows of the run: `time`, and a column for each element of a signal."""
        return pd.read_parquet(self.folder / SIGNALS)


def options(run: RunPlan) -> Options:
    """The options with which `macrostep run` would execute the same run."""
    replacements = dict(zip(_REPLACED, (run.plant, run.controller), strict=True))
    return Options(mode=MODE, replacements=replacements, settings=list(run.settings))


def command(run: RunPlan) -> str:
    """The command that executes the same run."""
    settings = "".join(f" --set {setting}" for setting in run.settings)
    return f"macrostep run {run.scenario} --plant {run.plant} --controller {run.controller}{settings}"


def build(experiments: Experiments, progress: Progress) -> None:
    """Build every FMU that the experiments need, before several processes ask for the same one."""
    runs = experiments.all_runs()
    blocks = {name for run in runs for name in (run.plant, run.controller)}
    if experiments.timing is not None:
        blocks |= set(experiments.timing.controllers)
    build_blocks(blocks, {run.scenario for run in runs}, progress)


def build_blocks(blocks: Collection[str], scenarios: Collection[str], progress: Progress) -> None:
    """Build the FMUs of those that are native among some blocks and those that scenarios contain.

    Args:
        blocks: The blocks that replace the plant and the controller of the scenarios.
        scenarios: The scenarios.
        progress: Receives a report on each FMU that is built.
    """
    fillings = (filling for name in scenarios for filling in scenario_file.read(name)[1].units.items())
    kept = {part.block for socket, part in fillings if socket not in _REPLACED and part.block is not None}
    native = [BLOCKS[name] for name in sorted({*blocks, *kept}) if BLOCKS[name].native]
    catalogue.ensure_built(native, [MODE], catalogue.built_folder(), progress)


def execute(run: RunPlan, folder: Path) -> Outcome:
    """Execute one run and write its folder; runs of a sweep get no figures."""
    scenario = prepare.prepare(run.scenario, options(run))
    execution = runner.Execution(Afterwards(), figures=run.role is not RunRole.SWEEP)
    summary = runner.execute(scenario, folder, SILENT, execution).summary
    figures = (f"figures {summary['figures']}",) if "figures" in summary else ()
    return Outcome(run, folder, shown(scenario.system), scenario.remarks + figures)


def execute_all(runs: Sequence[RunPlan], folder: Path, pool: Executor, progress: Progress) -> dict[str, Outcome]:
    """Execute all runs, each in `folder/NAME`.

    Slow runs begin first, so that no core is idle while the last one ends.

    Args:
        runs: The runs as they were planned.
        folder: The folder of all run folders.
        pool: The processes that execute the runs.
        progress: Receives a report on each run.

    Returns:
        The outcomes by the name of the run, in the order of `runs`.
    """
    order = sorted(runs, key=lambda run: BLOCKS[run.controller].native)
    futures = [pool.submit(execute, run, folder / run.name) for run in order]
    outcomes: dict[str, Outcome] = {}
    for future in as_completed(futures):
        outcome = future.result()
        outcomes[outcome.run.name] = outcome
        progress.now(f"run {len(outcomes)} of {len(runs)}: {outcome.run.name}")
    return {run.name: outcomes[run.name] for run in runs}
