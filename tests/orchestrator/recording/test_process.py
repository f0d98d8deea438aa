"""The process that records, on both sides of its pipe: `process.py`, `messages.py` and `worker.py`."""

from __future__ import annotations

import contextlib
import io
import os
import queue
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from fmus.toolchain.child_process import _SECRET
from orchestrator.recording import worker
from orchestrator.recording.messages import NewRows, RecordingRequest, send
from orchestrator.recording.process import RecordingProcess
from orchestrator.results.run_folder import write_system
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from tests.waiting import wait_until

pytestmark = pytest.mark.filterwarnings("ignore:RRD file has no footer")


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks", stop_time=2.0))


@pytest.fixture
def simulation(static, tmp_path):
    write_system(static, tmp_path)
    with Simulation(static.system, h=static.h, until=static.until) as made:
        yield made


def request(simulation, folder):
    return RecordingRequest(folder, folder / "recording.rrd", simulation.log.elements, {"status": "running"})


def as_sent(message):
    stream = io.BytesIO()
    send(stream, message)
    return stream.getvalue()


class WhoReadsThis:
    def __reduce__(self):
        return threading.current_thread, ()


def test_the_thread_that_takes_messages_leaves_their_meaning_and_its_imports_to_the_main_one():
    messages = queue.SimpleQueue()
    stream = io.BytesIO(as_sent(WhoReadsThis()) * 2 + as_sent(WhoReadsThis())[:-1])
    thread = threading.Thread(target=worker._receive, args=(stream, messages))
    thread.start()
    thread.join()
    assert worker._waiting(messages) == [threading.main_thread()] * 2 + [None]


def read(folder):
    """How many ticks were recorded, and what is said about the run."""
    ticks, said = 0, ""
    for chunk in RrdReader(folder / "recording.rrd").stream():
        if chunk.entity_path == "/signals/plant/state/x" and not chunk.is_static:
            ticks += chunk.num_rows
        if chunk.entity_path == "/about":
            said = str(chunk.to_record_batch().column("TextDocument:text").to_pylist()[-1])
    return ticks, said


def ticks_so_far(folder):
    with contextlib.suppress(RuntimeError):  # read in the middle of a message
        return read(folder)[0]
    return 0


def test_rows_are_recorded_while_the_simulation_steps(simulation, tmp_path):
    with RecordingProcess(0.05) as process:
        process.begin(request(simulation, tmp_path), simulation)
        process.wait_until_open()
        for _ in range(10):
            simulation.step()
        wait_until(lambda: ticks_so_far(tmp_path) >= 10)
        simulation.run()
        process.end({"status": "finished"})
        assert process.wait() == ""
    ticks, said = read(tmp_path)
    assert ticks == 21
    assert "finished" in said
    assert not (tmp_path / ".recording.rrd").exists()


def test_a_recording_whose_run_died_is_completed(simulation, tmp_path):
    simulation.run()
    command = [sys.executable, "-m", "orchestrator.recording.worker"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        process.stdin.write(bytes(_SECRET))
        process.stdin.write(as_sent(request(simulation, tmp_path)))
        process.stdin.write(as_sent(NewRows(simulation.log.batches(0, 15, simulation.step_times))))
        process.stdin.write(as_sent(NewRows(simulation.log.batches(15, 21, simulation.step_times)))[:-100])
        process.stdin.close()  # in the middle of a message
        assert process.wait() == 0
    ticks, said = read(tmp_path)
    assert ticks == 15
    assert "cut short" in said


def test_the_process_does_without_pandas_which_takes_longer_to_import_than_rerun(simulation, tmp_path):
    simulation.run()
    with RecordingProcess() as process:
        process.begin(request(simulation, tmp_path), simulation)
        process.wait_until_open()
        maps = [path.read_text() for path in Path("/proc").glob("[0-9]*/maps") if _is_ours(path)]
        process.end({})
        assert process.wait() == ""
    libraries = "".join(maps)
    assert "rerun" in libraries
    assert "site-packages/pandas" not in libraries
    assert "site-packages/matplotlib" not in libraries
    assert read(tmp_path)[0] == 21


def _is_ours(maps):
    """Whether it is the memory of the process that records for this one."""
    try:
        return b"orchestrator.recording.worker" in (maps.parent / "cmdline").read_bytes() and os.access(maps, os.R_OK)
    except OSError:
        return False


def test_a_process_of_which_nothing_was_asked_is_gone_at_once():
    with RecordingProcess() as process:
        child = process._child._process
    assert child.returncode is not None
    assert process.wait() == ""


def test_a_process_that_takes_too_long_is_ended_and_one_that_fails_says_why(simulation, tmp_path):
    with RecordingProcess() as process:
        process.begin(request(simulation, tmp_path), simulation)
        process.end({})
        assert process.wait(0.0) == "not finished within 0 s"
    with RecordingProcess() as process:
        process.begin(RecordingRequest(tmp_path / "nowhere", tmp_path / "x.rrd", [], {}), simulation)
        process.end({})
        assert "nowhere/system.ssp: found no such file" in process.wait()


def test_nobody_waits_for_a_process_that_is_gone(simulation, tmp_path):
    with RecordingProcess() as process:
        process._child.kill()
        process._child.death()
        process.begin(request(simulation, tmp_path), simulation)
        process.wait_until_open()
        assert process._open.is_set(), "not because its time is over"
        process.end({})
        assert process.wait() in {"exit code -9", "exit code -15"}  # the keeper's, where it was first
    assert not process._thread.is_alive()


def test_rows_that_cannot_be_handed_on_are_told_of(simulation, tmp_path, monkeypatch):
    def batches(*_):
        raise MemoryError("too many rows")

    monkeypatch.setattr(simulation.log, "batches", batches)
    with RecordingProcess() as process:
        process.begin(request(simulation, tmp_path), simulation)
        process.end({})
        assert process.wait() == "MemoryError: too many rows"


def test_a_process_that_is_killed_leaves_no_files_but_the_recording(simulation, tmp_path, monkeypatch):
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setenv("TMPDIR", str(scratch))
    with RecordingProcess() as process:
        process.begin(request(simulation, tmp_path), simulation)
        process.wait_until_open()
        process._child.kill()
    assert list(scratch.iterdir()) == []


def test_a_run_that_breaks_off_is_said_to_be_cut_short(simulation, tmp_path):
    def run():
        with RecordingProcess() as process:
            process.begin(replace(request(simulation, tmp_path), about={"unit": "x", "status": "running"}), simulation)
            process.wait_until_open()
            for _ in range(5):
                simulation.step()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run()
    ticks, said = read(tmp_path)
    assert ticks == 5
    assert "| unit | x |" in said
    assert "| status | cut short |" in said


@pytest.mark.slow
def test_a_process_whose_viewer_hangs_does_not_outlive_its_run_for_long(simulation, tmp_path):
    simulation.run()
    command = [sys.executable, "-m", "orchestrator.recording.worker"]
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"rerun+http://127.0.0.1:{silent.getsockname()[1]}/proxy"
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
            process.stdin.write(bytes(_SECRET))
            process.stdin.write(as_sent(replace(request(simulation, tmp_path), sink=url)))
            process.stdin.write(as_sent(NewRows(simulation.log.batches(0, 21, simulation.step_times))))
            process.stdin.close()
            assert process.wait() == 1
