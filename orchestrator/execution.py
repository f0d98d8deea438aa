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
from typing import Any, Final, TypeAlias

from components.interfaces.arguments import checked_arguments
from components.interfaces.buses import VehicleState
from components.interfaces.interruption import without_interrupts
from components.interfaces.progress import SILENT, Progress
from orchestrator.recording.messages import Recorder, RecordingRequest, new_identifier
from orchestrator.recording.recording import Afterwards
from orchestrator.recording.run_recording import RunRecording
from orchestrator.results import summary
from orchestrator.results.claimed_folder import ClaimedFolder
from orchestrator.results.departure import Departure, has_left
from orchestrator.results.growth import growth_remarks
from orchestrator.results.live_folder import LiveFolder
from orchestrator.results.metrics import Chosen
from orchestrator.results.provenance import facts, measured_facts
from orchestrator.results.ranges import range_remarks
from orchestrator.results.row_files import RowFiles
from orchestrator.results.run_folder import FIGURES, RECORDING, new_folder
from orchestrator.results.task import start_remarks
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.paces import paces, without_gaps
from orchestrator.stepping.pacing import Pacer
from orchestrator.stepping.whole_run import simulation_of
from orchestrator.system.experiment import EVERYTHING, Scenario
from orchestrator.system.shown import shown, signal_path, unit_that_shows
from orchestrator.viewing.live import LiveStream

_Ending: TypeAlias = SimulationError | KeyboardInterrupt | None
"""What ended a run before its stop time."""
_DRAWN: Final = 20_000
"""The most rows that figures are drawn of; of a longer run, every second row, or third, and so on."""


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
    name: str | None = None
    """What the recording is called in the viewer; as the scenario, if not given."""
    begun: Callable[[Path], None] = lambda _: None
    """Called with the run folder, an absolute path, before the first step, and again if it is moved during the run."""
    ending: Callable[[], None] = lambda: None
    """Called after the last step, before the folder is completed."""

    @property
    def recorders(self) -> list[Recorder]:
        """All that receive the rows of the run."""
        return [self.recorder] if self.live is None else [self.recorder, self.live]


@checked_arguments
def execute(
    scenario: Scenario, out: Path | None = None, progress: Progress = SILENT, execution: Execution | None = None
) -> Finished:
    """Run a scenario and write its run folder; after a fault or Ctrl-C the folder holds every row up to it.

    Args:
        scenario: The system and its experiment, as `load` gives it.
        out: The run folder, which is new or holds a former run; the next free `runs/NAME-N` if not given.
        progress: Receives reports on what is going on.
        execution: How the run is recorded, watched and paced; as fast as it can, unwatched, if not given.

    Returns:
        The folder, the summary, and what ended the run early, if anything did.

    Raises:
        RequestError: The scenario cannot be simulated, or the folder cannot be used; nothing is written.
    """
    simulation = simulation_of(scenario)
    scenario = replace(scenario, system=simulation.system)  # what is recorded besides outputs has been added
    here = Path.cwd()  # no path is relative to where an FMU may lead this process
    with ExitStack() as undisturbed:
        with ExitStack() as running:
            # A library that cannot be loaded leaves no folder behind.
            fault = _attempt(lambda: running.enter_context(simulation))
            claimed = undisturbed.enter_context(new_folder(scenario.name, out, here))
            execution = execution or Execution()
            run = _Run(scenario, simulation, execution, claimed)
            undisturbed.enter_context(run.rows)
            try:
                run.begin()
                progress.now(lambda: f"stepping {scenario.name}: {simulation.time:.4g} s of {scenario.until:g} s")
                ended = fault or run.step()
            except KeyboardInterrupt as interrupt:  # Ctrl-C before the first step
                ended = fault or interrupt
            undisturbed.enter_context(without_interrupts())
            execution.ending()
            # All rows are on disk before the units are closed, which may take seconds, or end this process.
            run.keep(ended)
        return run.conclude(progress)


class _Run:
    """A run whose folder is there."""

    def __init__(
        self, scenario: Scenario, simulation: Simulation, execution: Execution, claimed: ClaimedFolder
    ) -> None:
        self._scenario, self._simulation, self._execution = scenario, simulation, execution
        self._pacer = None if execution.realtime is None else Pacer(execution.realtime, scenario.h)
        self._known = summary.draft(scenario, simulation)
        self.folder = LiveFolder(claimed, scenario, self._known, execution.begun)
        self.rows = RowFiles(self.folder, scenario, simulation)
        path = self.folder.path
        about = facts(self._known)
        name, elements = execution.name, simulation.log.elements
        self._request = RecordingRequest(path, path / RECORDING, elements, about, new_identifier(name), name=name)
        self._recording = RunRecording(execution.recorder, self._request, simulation, self.folder)
        self._ended: _Ending = None
        self._content: dict[str, Any] = {}

    def begin(self) -> None:
        """Begin to record; from here on there is a file, whatever happens."""
        for recorder in self._execution.recorders:
            recorder.begin(self._request, self._simulation)
        if self._execution.figures and self._scenario.scene is not None:
            with suppress(ImportError):  # `_draw` reports it
                import_module("orchestrator.pictures.figures")  # this takes as long as the recorders need to get ready
        for recorder in self._execution.recorders:
            recorder.wait_until_open()

    def step(self) -> _Ending:
        """Step to the stop time, or off the road; return what ended the run before, if anything did."""
        return _step(self._simulation, self._pacer, _off_road(self._scenario, self._simulation))

    def keep(self, ended: _Ending) -> None:
        """See to it that all rows are on disk, and what is known of the run that has ended."""
        self.rows.finish()
        self._ended = ended or self._fault(self.rows.problem)
        if self.rows.problem:
            self._recording.give_up(f"the rows need its room: {self.rows.problem}")
            self.rows.finish()
        self._columns = self.rows.columns()
        self._content = summary.summary(self._scenario, self._simulation, self._columns, self._ended, self._known)
        ending = summary.ending(self._ended) | measured_facts(self._content)
        self._recording.end(ending)
        if self._execution.live is not None:
            self._execution.live.end({**self._request.about, **ending})
        if self._pacer is not None:
            self._content["realtime"] = self._pacer.report()
        self.folder.write_draft(self._content)

    def conclude(self, progress: Progress) -> Finished:
        """Complete the folder, when the units are closed."""
        content = self._content
        progress.now("drawing the figures")  # while the recording is written on another core
        if self._execution.figures and (failed := _draw(self._scenario, self._columns, self.folder.path / FIGURES)):
            content["figures"] = f"not drawn: {failed}"
        progress.now("writing the recording")
        notes = [*self._recorded(), *growth_remarks(self._columns, self._scenario.system.units)]
        plant = unit_that_shows(shown(self._scenario.system), VehicleState)
        notes += start_remarks(content["metrics"], plant, content["units"].get(plant, {}).get("kind", ""))
        notes += range_remarks(content.get("out_of_range", {}))
        if "departure" in content:
            ends = "; the run ends there" if self._scenario.end_off_road else "; figures and metrics end there"
            notes.append(f"{Departure(**content['departure'])}{ends}")
        if unwritten := self.folder.conclude(content):
            self._ended = self._ended or self._fault(unwritten)
            notes.append(unwritten)
        return Finished(self.folder.named, content, self._ended, (*self.folder.remarks(), *notes))

    def _recorded(self) -> list[str]:
        """Wait for the recording and for the viewer; return notes on what went wrong."""
        recording, live = self._recording.wait(), self._execution.live
        log, system = self._simulation.log, self._simulation.system
        notes = list(self._simulation.remarks)
        if len(log.at_every_tick) < len(paces(system, EVERYTHING)):
            notes.append("not every signal is recorded at every tick; what is computed from it is left out")
        notes += recording
        notes += [behind] if live is not None and (behind := live.wait()) else []
        return notes

    def _fault(self, problem: str) -> SimulationError | None:
        """Something that no unit is to blame for, as the end of a run."""
        simulation = self._simulation
        return SimulationError(max(simulation.tick, 0), simulation.time, "", problem) if problem else None


def _attempt(action: Callable[[], object]) -> SimulationError | None:
    try:
        action()
    except SimulationError as error:
        return error
    return None


def _off_road(scenario: Scenario, simulation: Simulation) -> Callable[[], bool] | None:
    """What says whether the vehicle has left the surroundings of the road; None where the run does not end there."""
    scene, buses = scenario.scene, shown(scenario.system)
    if not scenario.end_off_road or scene is None or VehicleState not in buses:
        return None
    x, y = (signal_path(buses, VehicleState, axis) for axis in "xy")
    return lambda: bool(has_left(simulation.read(x), simulation.read(y), scene))


def _step(
    simulation: Simulation, pacer: Pacer | None, off_road: Callable[[], bool] | None
) -> SimulationError | KeyboardInterrupt | None:
    """Step to the stop time, or off the road; return what ended the run before, if anything did."""
    try:
        if pacer is None and off_road is None:
            simulation.run()
            return None
        while not simulation.is_over:
            tick = simulation.tick + 1
            if pacer is not None:
                pacer.wait(tick)
            simulation.step()
            if pacer is not None:
                pacer.done(tick)
            if off_road is not None and off_road():
                break
    except (SimulationError, KeyboardInterrupt) as error:
        return error
    return None


def _draw(scenario: Scenario, columns: Mapping[str, Any], folder: Path) -> str:
    """Draw the figures of signals without gaps; return what went wrong in one line, or an empty text."""
    every = -(-len(columns["time"]) // _DRAWN) or 1
    rows = Chosen(columns, ("time", *sorted(without_gaps(scenario.system, scenario.record))), every)
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
