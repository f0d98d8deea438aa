"""One run of a scenario: it is stepped, recorded at the same time, and written to its run folder, whatever ends it."""

from __future__ import annotations

import logging
import traceback
import warnings
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from components.interfaces.interruption import without_interrupts
from components.interfaces.progress import Progress
from orchestrator.recording.messages import Recorder, RecordingRequest
from orchestrator.recording.recording import Afterwards
from orchestrator.results import summary
from orchestrator.results.growth import growth_remarks
from orchestrator.results.parquet import write_signals
from orchestrator.results.provenance import facts, versions
from orchestrator.results.run_folder import FIGURES, RECORDING, SIGNALS, new_folder, write_system
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.pacing import Pacer
from orchestrator.stepping.rows import paces, without_gaps
from orchestrator.system.experiment import EVERYTHING, Scenario
from orchestrator.viewing.live import LiveStream


@dataclass(frozen=True)
class Finished:
    """A run that has ended."""

    folder: Path
    """The run folder."""
    summary: dict[str, Any]
    """The content of `summary.json`."""
    ended: SimulationError | KeyboardInterrupt | None
    """What ended the run before its stop time."""
    notes: tuple[str, ...]
    """Problems of the recording and of the live stream, which do not end a run."""


@dataclass(frozen=True)
class Execution:
    """How a run is executed: its recorder, its live stream, its pace, and whether figures are drawn."""

    recorder: Recorder = field(default_factory=Afterwards)
    """Writes `recording.rrd`; after the run, if not given."""
    live: LiveStream | None = None
    """Streams the run to a viewer."""
    realtime: float | None = None
    """Simulated seconds per second of wall time; without it the run goes as fast as it can."""
    figures: bool = True
    begun: Callable[[Path], None] = lambda _: None
    """Called with the run folder, an absolute path, before the first step, when it is there."""
    ending: Callable[[], None] = lambda: None
    """Called after the last step, before the folder is completed."""

    @property
    def recorders(self) -> list[Recorder]:
        """All that receive the rows of the run."""
        return [self.recorder] if self.live is None else [self.recorder, self.live]


def execute(scenario: Scenario, out: Path | None, progress: Progress, execution: Execution) -> Finished:
    """Run a scenario and write its run folder; after a fault or Ctrl-C the folder holds every row up to it.

    Args:
        scenario: The system and its experiment, as `load` gives it.
        out: The run folder, which is new or holds a former run; the next free `runs/NAME-N` if not given.
        progress: Receives reports on what is going on.
        execution: How the run is recorded, watched and paced.

    Returns:
        The folder, the summary, and what ended the run early, if anything did.

    Raises:
        RequestError: The scenario cannot be simulated, or the folder cannot be used; nothing is written.
    """
    pacer = None if execution.realtime is None else Pacer(execution.realtime, scenario.h)
    simulation = _simulation(scenario)
    scenario = replace(scenario, system=simulation.system)  # what is recorded besides outputs has been added
    here = Path.cwd()  # no path is relative to where an FMU may lead this process
    with ExitStack() as undisturbed:
        with ExitStack() as running:
            # A library that cannot be loaded leaves no folder behind.
            fault = _attempt(lambda: running.enter_context(simulation))
            named = new_folder(scenario.name, out)
            folder = here / named
            execution.begun(folder)
            write_system(scenario, folder)
            request = RecordingRequest(
                folder.resolve(), folder.resolve() / RECORDING, simulation.log.elements, _about(scenario)
            )
            try:
                _begin(execution, request, simulation, figures=execution.figures and scenario.scene is not None)
                progress.now(f"stepping {scenario.name}")
                ended = fault or _step(simulation, pacer)
            except KeyboardInterrupt as interrupt:  # Ctrl-C before the first step
                ended = fault or interrupt
            # Closing the units may take several seconds, and Ctrl-C must not interrupt that either.
            undisturbed.enter_context(without_interrupts())
            execution.ending()
        for recorder in execution.recorders:
            recorder.end(request.about | summary.ending(ended))
        columns = simulation.columns()
        write_signals(columns, scenario, folder / SIGNALS)
        content = summary.summary(scenario, simulation, columns, ended)
        if pacer is not None:
            content["realtime"] = pacer.report()
        progress.now("drawing the figures")  # while the recording is written on another core
        if execution.figures and (failed := _draw(scenario, columns, folder / FIGURES)):
            content["figures"] = f"not drawn: {failed}"
        progress.now("writing the recording")
        notes = (
            *_recorded(execution, request, simulation, summary.ending(ended)),
            *growth_remarks(columns, scenario.system.units),
        )
        summary.write_summary(content, folder)
    return Finished(named, content, ended, notes)


def _simulation(scenario: Scenario) -> Simulation:
    return Simulation(
        scenario.system,
        h=scenario.h,
        until=scenario.until,
        start=scenario.start,
        tolerance=scenario.tolerance,
        record=scenario.record,
        algorithm=scenario.algorithm,
        solve_loops=scenario.solve_loops,
    )


def _begin(execution: Execution, request: RecordingRequest, simulation: Simulation, *, figures: bool) -> None:
    """Begin to record; from here on there is a file, whatever happens."""
    for recorder in execution.recorders:
        recorder.begin(request, simulation)
    if figures:
        with suppress(ImportError):  # `_draw` reports it
            import_module("orchestrator.pictures.figures")  # this takes as long as the recorders need to get ready
    for recorder in execution.recorders:
        recorder.wait_until_open()


def _attempt(action: Callable[[], object]) -> SimulationError | None:
    try:
        action()
    except SimulationError as error:
        return error
    return None


def _step(simulation: Simulation, pacer: Pacer | None) -> SimulationError | KeyboardInterrupt | None:
    """Step to the stop time; return what ended the run before it, if anything did."""
    try:
        if pacer is None:
            simulation.run()
        else:
            for tick in range(simulation.last_tick + 1):
                pacer.wait(tick)
                simulation.step()
                pacer.done(tick)
    except (SimulationError, KeyboardInterrupt) as error:
        return error
    return None


def _draw(scenario: Scenario, columns: Mapping[str, Any], folder: Path) -> str:
    """Draw the figures of signals without gaps; return what went wrong in one line, or an empty text."""
    whole = {"time", *without_gaps(scenario.system, scenario.record)}
    rows = {name: values for name, values in columns.items() if name in whole}
    if scenario.scene is None or not len(rows["time"]):
        return ""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it logs that it builds its font cache
    try:
        from orchestrator.pictures import figures  # noqa: PLC0415 - slow to import

        with warnings.catch_warnings(action="ignore"):
            figures.draw(rows, scenario.system, scenario.scene, folder)
    except Exception as error:  # noqa: BLE001 - figures are best effort, and the summary reports it
        return traceback.format_exception_only(error)[-1].strip().splitlines()[-1]
    return ""


def _recorded(
    execution: Execution, request: RecordingRequest, simulation: Simulation, ending: Mapping[str, str]
) -> tuple[str, ...]:
    """Wait for the recording and for the viewer; return notes on what went wrong."""
    problem = execution.recorder.wait()
    if problem:  # The recording process died, but this process still has all rows.
        again = Afterwards()
        again.begin(request, simulation)
        again.end({**request.about, **ending})
        problem = again.wait()
    missing = len(simulation.log.at_every_tick) < len(paces(simulation.system, EVERYTHING))
    notes = list(simulation.remarks)
    notes += ["not every signal is recorded at every tick; what is computed from it is left out"] if missing else []
    notes += [f"recording.rrd is not whole: {problem}"] if problem else []
    notes += [behind] if execution.live is not None and (behind := execution.live.wait()) else []
    return tuple(notes)


def _about(scenario: Scenario) -> dict[str, str]:
    """The provenance of the run, which its recording shows."""
    content = {"scenario": scenario.name, "title": scenario.title, "status": "running"}
    return facts({**content, "units": summary.units(scenario.system), "versions": versions()})
