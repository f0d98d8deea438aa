"""One run from request to folder: prepare, step, record, and keep what there is when something fails."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from components.interfaces.problem import refuse
from orchestrator import recorder, ssp_reader
from orchestrator.drawing import FigureProcess
from orchestrator.master import Simulation, SimulationError
from orchestrator.parquet import write_signals
from orchestrator.scenario import Options, Scenario, parse_settings, prepare


@dataclass(frozen=True)
class Finished:
    """What a run left behind."""

    folder: Path
    summary: dict[str, Any]
    fault: SimulationError | None


def load(request: str, options: Options, progress: Callable[[str], None]) -> Scenario:
    """A scenario by name or file, a system in an `.ssp` file, or the system of a former run. Raises `RequestError`."""
    path = Path(request)
    if path.is_dir():
        if not recorder.is_run(path):
            raise refuse(request, "a folder without system.ssp", "a scenario, an .ssp file or a run folder")
        path = path / "system.ssp"
    if path.suffix == ".ssp":
        if options.replacements or options.mode != Options().mode:
            raise refuse(
                request, "--blocks, --fmi or another unit for a fixed system", "--set, --step, --stop-time, --out"
            )
        found = ssp_reader.read(path, parse_settings(options.settings), options.step, options.stop_time)
        if path.parent == Path(request) and not (path.parent / recorder.SUMMARY).is_file():
            found = replace(found, remarks=("that run was cut short; this one begins anew",))
        return found
    return prepare(request, options, progress)


def execute(scenario: Scenario, out: Path | None, progress: Callable[[str], None], drawing: FigureProcess) -> Finished:
    """Run `scenario` and write its folder; a fault ends the run and keeps every row up to it. Raises `RequestError`."""
    simulation = Simulation(scenario.system, h=scenario.h, until=scenario.until)
    with ExitStack() as running:
        fault = _attempt(lambda: running.enter_context(simulation))  # a library that cannot be loaded leaves no folder
        folder = recorder.new_folder(scenario.name, out)
        recorder.write_system(scenario, folder)
        if fault is None:
            progress(f"stepping {scenario.name}")
            fault = _attempt(simulation.run)
    frame = simulation.frame()
    write_signals(frame, scenario, folder / "signals.parquet")
    drawing.start(folder)
    told = recorder.summary(scenario, simulation, frame, fault)
    progress("writing the recording")
    _record(scenario, simulation, frame, told, folder)
    progress("drawing the figures")
    if failed := drawing.wait():
        told["figures"] = f"not drawn: {failed.splitlines()[-1]}"
    recorder.write_summary(told, folder)
    return Finished(folder, told, fault)


def _attempt(action: Callable[[], object]) -> SimulationError | None:
    try:
        action()
    except SimulationError as error:
        return error
    return None


def _record(
    scenario: Scenario, simulation: Simulation, frame: pd.DataFrame, told: dict[str, Any], folder: Path
) -> None:
    from orchestrator.rerun_stream import RerunStream  # noqa: PLC0415 - Rerun is slow to import

    about = {
        "scenario": f"{scenario.name}: {scenario.title}",
        "status": told["status"],
        **{f"unit {name}": f"{unit['kind']}, {unit['runs_as']}" for name, unit in told["units"].items()},
        **told["versions"],
    }
    stream = RerunStream(
        folder / "recording.rrd",
        scenario.system,
        scenario.scene,
        name=scenario.name,
        h=scenario.h,
        about=about,
    )
    try:
        stream.log(frame, simulation.step_times)
    finally:
        stream.close()
