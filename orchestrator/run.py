"""One run from request to folder: prepare, step, record beside it, and keep what there is when something fails."""

from __future__ import annotations

import logging
import signal
import threading
import traceback
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from orchestrator.recording.messages import Recorder, RecordingRequest
from orchestrator.recording.recording import Afterwards
from orchestrator.results import summary
from orchestrator.results.parquet import write_signals
from orchestrator.results.provenance import versions
from orchestrator.results.run_folder import FIGURES, RECORDING, SIGNALS, new_folder, write_system
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.pacing import Pacer
from orchestrator.stepping.rows import paces, without_gaps
from orchestrator.system.experiment import EVERYTHING, Scenario
from orchestrator.viewing.live import LiveStream


@dataclass(frozen=True)
class Finished:
    """What a run left behind."""

    folder: Path
    summary: dict[str, Any]
    ended: SimulationError | KeyboardInterrupt | None
    """What ended the run before its time"""
    notes: tuple[str, ...]
    """What did not go well beside it"""


@dataclass(frozen=True)
class Beside:
    """What goes on beside the stepping, and after it."""

    recording: Recorder
    live: LiveStream | None = None
    """Who streams to a viewer"""
    realtime: float | None = None
    """Seconds to simulate in a second; as fast as possible if not given"""
    figures: bool = True
    """Whether figures are drawn"""


def execute(scenario: Scenario, out: Path | None, progress: Callable[[str], None], beside: Beside) -> Finished:
    """Run `scenario` and write its folder; a fault or Ctrl-C ends the run and keeps every row up to it.

    Raises `RequestError`.
    """
    pacer = None if beside.realtime is None else Pacer(beside.realtime, scenario.h)
    simulation = Simulation(
        scenario.system,
        h=scenario.h,
        until=scenario.until,
        record=scenario.record,
        algorithm=scenario.algorithm,
        solve_loops=scenario.solve_loops,
    )
    streams: list[Recorder] = [beside.recording] if beside.live is None else [beside.recording, beside.live]
    with ExitStack() as leaving:
        with ExitStack() as running:
            # a library that cannot be loaded leaves no folder
            fault = _attempt(lambda: running.enter_context(simulation))
            folder = new_folder(scenario.name, out)
            write_system(scenario, folder)
            request = RecordingRequest(
                folder.resolve(), folder.resolve() / RECORDING, simulation.log.elements, _about(scenario)
            )
            try:
                _begin(streams, request, simulation, figures=beside.figures and scenario.scene is not None)
                progress(f"stepping {scenario.name}")
                ended = fault or _step(simulation, pacer)
            except KeyboardInterrupt as interrupt:  # before the first step
                ended = fault or interrupt
            leaving.enter_context(_undisturbed())  # before units are closed, which may take them a while
        for stream in streams:
            stream.end(request.about | summary.ending(ended))
        columns = simulation.columns()
        write_signals(columns, scenario, folder / SIGNALS)
        told = summary.summary(scenario, simulation, columns, ended)
        if pacer is not None:
            told["realtime"] = pacer.report()
        progress("drawing the figures")  # while the recording is written on another core
        if beside.figures and (failed := _draw(scenario, columns, folder / FIGURES)):
            told["figures"] = f"not drawn: {failed}"
        progress("writing the recording")
        notes = _recorded(beside, request, simulation, summary.ending(ended))
        summary.write_summary(told, folder)
    return Finished(folder, told, ended, notes)


def _begin(streams: Sequence[Recorder], request: RecordingRequest, simulation: Simulation, *, figures: bool) -> None:
    """Begin to record; from here on there is a file, whatever happens."""
    for stream in streams:
        stream.begin(request, simulation)
    if figures:
        with suppress(ImportError):  # `_draw` tells of it
            import_module("orchestrator.pictures.figures")  # slow, as is a recorder that gets ready on another core
    for stream in streams:
        stream.wait_until_open()


@contextmanager
def _undisturbed() -> Generator[None]:
    """What a run leaves behind is written in any case: Ctrl-C waits for the few seconds that it takes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _attempt(action: Callable[[], object]) -> SimulationError | None:
    try:
        action()
    except SimulationError as error:
        return error
    return None


def _step(simulation: Simulation, pacer: Pacer | None) -> SimulationError | KeyboardInterrupt | None:
    """Step to the end; what ended it before, if anything."""
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
    """Draw the figures of signals that have no gaps; what went wrong, in a line, or nothing."""
    whole = {"time", *without_gaps(scenario.system, scenario.record)}
    rows = {name: values for name, values in columns.items() if name in whole}
    if scenario.scene is None or not len(rows["time"]):
        return ""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # its cache of fonts is nothing to tell of a run
    try:
        from orchestrator.pictures import figures  # noqa: PLC0415 - slow to import

        with warnings.catch_warnings(action="ignore"):
            figures.draw(rows, scenario.system, scenario.scene, folder)
    except Exception as error:  # noqa: BLE001 - the run is worth its while without them, and the summary tells
        return traceback.format_exception_only(error)[-1].strip().splitlines()[-1]
    return ""


def _recorded(
    beside: Beside, request: RecordingRequest, simulation: Simulation, ending: Mapping[str, str]
) -> tuple[str, ...]:
    """Wait for the recording and the viewer; notes on what went wrong."""
    problem = beside.recording.wait()
    if problem:  # its process died, but the rows are here
        again = Afterwards()
        again.begin(request, simulation)
        again.end({**request.about, **ending})
        problem = again.wait()
    missing = len(simulation.log.at_every_tick) < len(paces(simulation.system, EVERYTHING))
    notes = ["not every signal is recorded at every tick; what is computed from it is left out"] if missing else []
    notes += [f"recording.rrd is not whole: {problem}"] if problem else []
    notes += [behind] if beside.live is not None and (behind := beside.live.wait()) else []
    return tuple(notes)


def _about(scenario: Scenario) -> dict[str, str]:
    """The run's provenance, for a person who looks at its recording."""
    units = summary.units(scenario.system)
    return {
        "scenario": f"{scenario.name}: {scenario.title}",
        "status": "running",
        **{f"unit {name}": f"{unit['kind']}, {unit['runs_as']}" for name, unit in units.items()},
        **versions(),
    }
