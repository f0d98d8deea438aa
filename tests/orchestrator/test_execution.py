"""Runs from request to folder: what is on disk while they step, when they are killed, and when their viewer hangs.

They show `run_recording.py` too: a recording that is written once more, or left out.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import warnings
from collections import defaultdict
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rerun.chunk import RrdReader

from components.interfaces.progress import SILENT
from orchestrator import execution
from orchestrator.execution import Execution, execute
from orchestrator.pictures.signals import signals
from orchestrator.recording.process import RecordingProcess
from orchestrator.recording.recording import Afterwards
from orchestrator.results import run_folder
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.pacing import Pacer
from orchestrator.viewing import rerun_program
from orchestrator.viewing.live import LiveOptions, LiveStream
from orchestrator.viewing.repair import whole_recording
from tests.waiting import wait_until

# a recording that was cut short has no footer, and Rerun says so
pytestmark = pytest.mark.filterwarnings("ignore:RRD file has no footer")

WALL_TIME = ["timing", "realtime"]


def static(**options):
    return prepare("static", Options(mode="blocks", **options))


def recorded(path):
    """Values of each signal by entity, in the order of ticks: (ticks, values)."""
    found = defaultdict(list)
    for chunk in RrdReader(path).stream():
        if chunk.entity_path.startswith("/signals/") and not chunk.is_static:
            batch = chunk.to_record_batch()
            rows = zip(batch.column("tick").to_pylist(), batch.column("Scalars:scalars").to_pylist(), strict=True)
            found[chunk.entity_path] += rows
    return {entity: tuple(zip(*sorted(rows), strict=True)) for entity, rows in found.items()}


def assert_same_values(folder, system):
    """`signals.parquet` and `recording.rrd` hold the same values at the same ticks."""
    frame = pd.read_parquet(folder / "signals.parquet")
    ticks = np.rint(frame["time"] / 0.1).astype(int)
    found = recorded(folder / "recording.rrd")
    kept = [s for s in signals(system) if s.columns[0] in frame]
    assert set(found) == {"/signals/" + s.path.replace(".", "/") for s in kept}
    for signal_ in kept:
        own = frame[list(signal_.columns)].astype(float)
        own.index = ticks
        own = own.dropna()
        at, values = found["/signals/" + signal_.path.replace(".", "/")]
        assert list(at) == own.index.tolist(), signal_.path
        np.testing.assert_array_equal(np.array(values), own.to_numpy(), err_msg=signal_.path)


@pytest.mark.parametrize(
    "record", [(), ("plant.*", "controller.*:4", "controller.solver.*:1"), ("traffic.obstacles.x:3",)], ids=str
)
def test_the_recording_and_the_parquet_file_hold_the_same_values(tmp_path, record):
    made = static(stop_time=3.0, record=record)
    with RecordingProcess() as recording:
        finished = execute(made, tmp_path / "r", SILENT, Execution(recording, figures=False))
    partly = "not every signal is recorded at every tick; what is computed from it is left out"
    assert finished.notes == ((partly,) if record else ())
    assert_same_values(tmp_path / "r", made.system)


def test_a_paced_run_gives_the_same_as_a_fast_one(tmp_path):
    made = static(stop_time=2.0)
    execute(made, tmp_path / "fast", SILENT, Execution(Afterwards(), figures=False))
    with RecordingProcess() as recording:
        execute(made, tmp_path / "paced", SILENT, Execution(recording, realtime=2.0, figures=False))
    assert_same_values(tmp_path / "paced", made.system)
    fast, paced = (pd.read_parquet(tmp_path / n / "signals.parquet") for n in ("fast", "paced"))
    assert fast.equals(paced)
    told = json.loads((tmp_path / "paced" / "summary.json").read_text())
    assert told["realtime"]["factor"] == 2.0
    assert sorted(p.name for p in (tmp_path / "paced").iterdir()) == [
        ".lock",
        "figures",
        "manifest.json",
        "recording.rrd",
        "signals.parquet",
        "summary.json",
        "system.ssp",
    ]


def test_a_fault_stands_in_the_log_of_the_recording_and_on_its_page(tmp_path):
    finished = execute(
        static(settings=["plant.C_alpha_f=1e300"]), tmp_path / "r", SILENT, Execution(Afterwards(), figures=False)
    )
    tick, reason = (finished.summary["fault"][name] for name in ("tick", "reason"))
    assert str(finished.ended) == f"tick {tick} (t = {tick * 0.1:g} s), unit `plant`: {reason}"
    lines, pages = [], []
    for chunk in RrdReader(tmp_path / "r" / "recording.rrd").stream():
        batch = chunk.to_record_batch()
        if chunk.entity_path == "/events":
            columns = ("tick", "TextLog:text", "TextLog:level")
            lines += zip(*(batch.column(name).to_pylist() for name in columns), strict=True)
        if chunk.entity_path == "/about":
            pages += [text for (text,) in batch.column("TextDocument:text").to_pylist()]
    told = " ".join(text.strip() for at, (text,), (level,) in lines if (at, level) == (tick, "ERROR"))
    assert f"fault in unit `plant`: {reason}" in told
    assert f"| fault | unit `plant`: {reason} |" in pages[-1]
    assert f"| fault at | tick {tick} (t = {tick * 0.1:g} s) |" in pages[-1]


def test_when_the_recording_process_dies_the_recording_is_written_all_the_same(tmp_path, monkeypatch):
    made = static(stop_time=2.0)
    with RecordingProcess() as recording:
        monkeypatch.setattr(Pacer, "done", lambda _, tick: recording._child._process.kill() if tick == 16 else None)
        finished = execute(made, tmp_path / "r", SILENT, Execution(recording, realtime=1.5, figures=False))
    assert finished.notes == ()
    assert_same_values(tmp_path / "r", made.system)
    assert not (tmp_path / "r" / ".recording.rrd").exists(), "what that process had begun"


def test_when_the_recording_process_hangs_the_recording_is_written_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr("orchestrator.recording.process._WRITES_WITHIN", 1.0)
    made = static(stop_time=2.0)
    with RecordingProcess() as recording:
        stop = recording._child._process.send_signal
        monkeypatch.setattr(Pacer, "done", lambda _, tick: stop(signal.SIGSTOP) if tick == 10 else None)
        finished = execute(made, tmp_path / "r", SILENT, Execution(recording, realtime=4.0, figures=False))
    assert finished.notes == ()
    assert_same_values(tmp_path / "r", made.system)


def test_a_recording_that_cannot_be_written_is_told_of_and_nothing_else_is_missing(tmp_path, monkeypatch):
    def close(*_):
        raise ValueError("no room")

    monkeypatch.setattr("orchestrator.recording.recording.Recording.close", close)
    finished = execute(static(stop_time=1.0), tmp_path / "r", SILENT, Execution(Afterwards(), figures=False))
    assert finished.notes == ("recording.rrd is left out: ValueError: no room; macrostep show makes one from the rows",)
    assert json.loads((tmp_path / "r" / "summary.json").read_text())["status"] == "finished"
    assert len(pd.read_parquet(tmp_path / "r" / "signals.parquet")) == 11


def test_metrics_that_need_what_was_not_recorded_are_left_out(tmp_path):
    made = static(stop_time=2.0, record=["plant.state.*"])
    finished = execute(made, tmp_path / "r", SILENT, Execution(Afterwards(), figures=False))
    assert {"r_peak", "gap_edge", "v_x_max"} <= finished.summary["metrics"].keys()
    assert not {"gap_obstacle", "path_error_max", "mu_f_max"} & finished.summary["metrics"].keys()
    made = static(stop_time=2.0, record=["*:3", "plant.state.x"])
    finished = execute(made, tmp_path / "r", SILENT, Execution(Afterwards(), figures=False))
    assert finished.summary["metrics"] == {}
    assert len(pd.read_parquet(tmp_path / "r" / "signals.parquet")) == 21


@pytest.mark.parametrize("record", [["plant.*", "controller.*:4"], ["*:2"], ["traffic.*:2", "plant.*:3"]], ids=str)
def test_figures_are_drawn_of_signals_that_have_no_gaps(tmp_path, record):
    execute(static(stop_time=2.0, record=record), tmp_path / "r", SILENT, Execution(Afterwards()))
    drawn = {path.stem for path in (tmp_path / "r" / "figures").iterdir()}
    assert ("yaw_rate" in drawn) == (len(record) == 1 or record[0] == "plant.*")
    assert ("path_error" in drawn) == (len(record) == 1)


def test_figures_that_cannot_be_drawn_are_told_of_and_nothing_else_is_missing(tmp_path, monkeypatch, capfd):
    def draw(*_):
        warnings.warn("a warning of matplotlib", stacklevel=1)
        raise ValueError("no fonts\nat all")

    monkeypatch.setattr("orchestrator.pictures.figures.draw", draw)
    made = static(stop_time=1.0)
    execute(made, tmp_path / "r", SILENT, Execution(Afterwards()))
    told = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert (told["figures"], told["status"]) == ("not drawn: at all", "finished")
    assert_same_values(tmp_path / "r", made.system)
    assert capfd.readouterr() == ("", "")


def test_ctrl_c_ends_a_run_in_order(tmp_path):
    command = [sys.executable, "-m", "orchestrator.command.main", "run", "static", "--blocks", "--realtime", "1"]
    process = subprocess.Popen(
        [*command, "--out", str(tmp_path / "r")], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    wait_until(lambda: recorded_ticks(tmp_path / "r" / "recording.rrd") > 2)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    told = json.loads((tmp_path / "r" / "summary.json").read_text())
    ticks = told["experiment"]["ticks"]
    assert (process.returncode, told["status"]) == (130, "interrupted")
    assert f"macrostep: interrupted after {ticks} ticks" in err
    assert 3 <= ticks < 114
    assert f"static: {ticks} ticks of 0.1 s" in out
    assert len(pd.read_parquet(tmp_path / "r" / "signals.parquet")) == ticks
    assert_same_values(tmp_path / "r", static().system)
    assert (tmp_path / "r" / "figures" / "trajectory.png").is_file()


def test_ctrl_c_once_more_does_not_disturb_what_the_first_began(tmp_path, monkeypatch):
    def press(*_):
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Pacer, "done", lambda _, tick: press() if tick == 3 else None)
    monkeypatch.setattr(execution.Simulation, "close", press)
    with RecordingProcess() as recording:
        finished = execute(
            static(stop_time=2.0), tmp_path / "r", SILENT, Execution(recording, realtime=100.0, figures=False)
        )
    assert (finished.summary["status"], finished.summary["experiment"]["ticks"]) == ("interrupted", 4)
    assert_same_values(tmp_path / "r", static().system)
    with pytest.raises(KeyboardInterrupt):
        press()


def recorded_ticks(path):
    """How many ticks can be read; 0 while there is no file, or not even its header."""
    try:
        return 1 + max(recorded(path)["/signals/plant/state/x"][0])
    except (KeyError, OSError, ValueError, RuntimeError):
        return 0


# -- killed at random ticks


def test_there_is_a_recording_before_the_first_step(tmp_path, monkeypatch):
    there, stepping = [], execution._step

    def step(*arguments):
        there.append((tmp_path / "r" / "recording.rrd").stat().st_size)
        return stepping(*arguments)

    monkeypatch.setattr(execution, "_step", step)
    with RecordingProcess() as recording:
        execute(static(stop_time=0.5), tmp_path / "r", SILENT, Execution(recording))
    assert there[0] > 0
    assert recorded_ticks(tmp_path / "r" / "recording.rrd") == 6


def run_to_be_killed(folder, stepped, recorder_pid):
    """The process that is killed: an endless run that says how far it has come."""

    def done(_, tick):
        stepped.value = tick

    Pacer.done = done
    with RecordingProcess() as recording:
        recorder_pid.value = recording._child._process.pid
        execute(static(stop_time=1000.0), folder, SILENT, Execution(recording, realtime=1.0, figures=False))


def killed(context, folder, seed):
    """Start a run, let it be killed at a random tick, and tell (ticks stepped, ticks that can be read)."""
    stepped, recorder_pid = context.Value("q", -1), context.Value("q", 0)
    process = context.Process(target=run_to_be_killed, args=(folder, stepped, recorder_pid), daemon=True)
    process.start()
    yield
    at = random.Random(seed).randint(1, 45)  # noqa: S311 - any tick will do
    wait_until(lambda: stepped.value >= at)
    if seed % 2:  # everything at once, as when a machine runs out of memory
        os.kill(recorder_pid.value, signal.SIGKILL)
    os.kill(process.pid, signal.SIGKILL)
    process.join()
    wait_until(lambda: not Path(f"/proc/{recorder_pid.value}").exists())
    yield stepped.value + 1, recorded(folder / "recording.rrd")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks for processes in /proc")
def test_a_run_that_is_killed_loses_two_seconds_at_most_and_never_the_file(tmp_path):
    with execution.Simulation(static().system, h=0.1, until=100.0) as simulation:
        simulation.run()
    whole = simulation.frame()
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([__name__, "orchestrator.execution"])
    lost = []
    for first in (0, 4):
        runs = [killed(context, tmp_path / str(seed), seed) for seed in range(first, first + 4)]
        for each in runs:
            next(each)
        for each in runs:
            stepped, found = next(each)
            ticks, x = found["/signals/plant/state/x"]
            assert list(ticks) == list(range(len(ticks)))
            assert [value for (value,) in x] == whole["plant.state.x"][: len(ticks)].tolist()
            lost.append(stepped - len(ticks))
    assert max(lost) <= 20, lost
    for name, is_whole in (("6", True), ("7", False)):  # with and without a process that completed the recording
        said, copies = [], tmp_path / f"copy of {name}"
        copies.mkdir()
        shown = recorded(whole_recording(run_folder.find(tmp_path / name), copies, said.append))
        there = recorded(tmp_path / name / "recording.rrd")
        if is_whole:
            assert (shown, said) == (there, [])
        else:
            (line,) = said
            assert line.startswith(f"{tmp_path / name}: a recording.rrd that is damaged; opening one made from ")
            (ticks, of_rows), (_, of_recording) = (found["/signals/plant/state/x"] for found in (shown, there))
            both = min(len(of_rows), len(of_recording))
            assert list(of_rows)[:both] == list(of_recording)[:both]
            assert len(ticks) > 0


# -- viewers that are slow, dead or hung


@contextmanager
def dead():
    """An address where nobody listens."""
    yield f"rerun+http://127.0.0.1:{rerun_program.free_port(0)}/proxy", lambda: None


@contextmanager
def silent():
    """A server that accepts and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"rerun+http://127.0.0.1:{server.getsockname()[1]}/proxy", lambda: None


@contextmanager
def stopped(how, by=signal.SIGSTOP):
    """A real viewer, or server of viewers, that is stopped or killed in mid-run."""
    port = rerun_program.free_port(0)
    process = rerun_program.serve(port, how)
    try:
        assert rerun_program.listens(port, 60, process)
        yield f"rerun+http://127.0.0.1:{port}/proxy", lambda: process.send_signal(by)
    finally:
        process.kill()
        process.wait()


@contextmanager
def slow():
    """A real server, at the end of a line that carries 40 kB/s."""
    with stopped(["--serve-grpc"]) as (url, _), socket.create_server(("127.0.0.1", 0)) as entry:
        port = int(re.findall(r":(\d+)/", url)[0])
        threading.Thread(target=carry_slowly, args=(entry, port), daemon=True).start()
        yield f"rerun+http://127.0.0.1:{entry.getsockname()[1]}/proxy", lambda: None


def carry_slowly(entry, port):
    def carry(source, target, pause):
        with suppress(OSError), source, target:
            while content := source.recv(4096):
                target.sendall(content)
                time.sleep(pause)

    with suppress(OSError):  # the test is over
        while True:
            here, there = entry.accept()[0], socket.create_connection(("127.0.0.1", port))
            for ends in ((here, there, 0.1), (there, here, 0.0)):
                threading.Thread(target=carry, args=ends, daemon=True).start()


VIEWERS = {
    "dead": dead,
    "silent": silent,
    "slow": slow,
    "server": lambda: stopped(["--serve-grpc"]),
    "killed": lambda: stopped(["--serve-grpc"], signal.SIGKILL),
    "viewer": lambda: stopped(["--headless", "--hide-welcome-screen"]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [*list(VIEWERS)[:-1], pytest.param("viewer", marks=pytest.mark.viewer)])
def test_a_viewer_that_hangs_changes_neither_results_nor_the_end(tmp_path, name, monkeypatch):
    made = static(stop_time=4.0)
    ended = {}
    step = execution._step

    def timed(simulation, *how):
        ended[simulation] = None
        found = step(simulation, *how)
        ended[simulation] = time.monotonic()
        return found

    monkeypatch.setattr(execution, "_step", timed)
    said, tails = [], []
    with VIEWERS[name]() as (url, stop), ExitStack() as stack:
        alone, recording, viewing = (
            RecordingProcess(),
            RecordingProcess(),
            LiveStream(LiveOptions(url=url), said.append),
        )
        for each in (alone, recording, viewing):
            stack.enter_context(each)
        execute(made, tmp_path / "alone", SILENT, Execution(alone, realtime=2.0, figures=False))
        tails.append(time.monotonic() - [*ended.values()][-1])
        monkeypatch.setattr(Pacer, "done", lambda _, tick: stop() if tick == 20 else None)
        watched = Execution(recording, viewing, realtime=2.0, figures=False)
        finished = execute(made, tmp_path / "watched", SILENT, watched)
        tails.append(time.monotonic() - [*ended.values()][-1])
    assert tails[1] < tails[0] + 60, "a viewer that is stopped is stopped for ever"
    alone, watched = (pd.read_parquet(tmp_path / n / "signals.parquet") for n in ("alone", "watched"))
    assert alone.equals(watched)
    assert_same_values(tmp_path / "watched", made.system)
    told = [json.loads((tmp_path / n / "summary.json").read_text()) for n in ("alone", "watched")]
    first, second = ({k: v for k, v in t.items() if k not in WALL_TIME} for t in told)
    assert first == second
    if name == "dead":
        assert said == [f"no viewer answers at {url}; the run goes on without it"]
        assert finished.notes == ()
    else:
        (note,) = finished.notes
        assert note == "the viewer did not take the whole run in time; the recording has it"
