"""What recording adds to a run: everything to parquet and Rerun (40 scalars and 10 spatial entities, and more), live.

`dynamic` moves its obstacles, so that hardly anything stands from one tick to the next.
"""

from __future__ import annotations

import time

import numpy as np
import pytest

from orchestrator import Options, Simulation, load
from orchestrator.recording.messages import RecordingRequest
from orchestrator.recording.process import RecordingProcess
from orchestrator.recording.recording import Recording
from orchestrator.results.parquet import write_signals
from orchestrator.results.run_folder import write_system
from orchestrator.stepping.pacing import Pacer
from orchestrator.viewing.live import LiveOptions, LiveStream

TICKS = 601
"""of 0.1 s: a simulated minute"""
BUDGET = {"per step": "150 us", "per simulated minute": "2 MB", "live, 99th percentile": "1 ms"}


@pytest.fixture(scope="module")
def dynamic():
    return load("dynamic", Options(mode="blocks", stop_time=(TICKS - 1) * 0.1))


@pytest.fixture(scope="module")
def minute(dynamic):
    with Simulation(dynamic.system, h=dynamic.h, until=dynamic.until) as simulation:
        simulation.run()
    assert len(simulation.log.at_every_tick) > 40
    return simulation


def test_a_simulated_minute_to_parquet_and_rerun(benchmark, dynamic, minute, tmp_path):
    """All that is done for the rows: the frame, the parquet file, the recording. One round is a minute."""
    path = tmp_path / "recording.rrd"

    def fresh():
        return (Recording(RecordingRequest(tmp_path, path, minute.log.elements, {}), dynamic),), {}

    def record(recording):
        write_signals(minute.frame(), dynamic, tmp_path / "signals.parquet")
        recording.log(minute.log.batches(0, TICKS, minute.step_times), last=True)
        recording.close({})

    benchmark.pedantic(record, setup=fresh, rounds=10, warmup_rounds=1)
    benchmark.extra_info["us per step"] = benchmark.stats["median"] / TICKS * 1e6
    benchmark.extra_info["MB"] = (path.stat().st_size + (tmp_path / "signals.parquet").stat().st_size) / 1e6
    benchmark.extra_info["budget"] = BUDGET


@pytest.mark.parametrize("beside", ["nothing", "recording"])
def test_stepping_while_a_process_records(benchmark, dynamic, tmp_path, beside):
    """The stepping thread alone: a simulated minute with and without a process that takes every row."""
    write_system(dynamic, tmp_path)
    with RecordingProcess() as process, Simulation(dynamic.system, h=0.1, until=600.0) as simulation:
        if beside == "recording":
            process.begin(RecordingRequest(tmp_path, tmp_path / "x.rrd", simulation.log.elements, {}), simulation)
            process.wait_until_open()

        def minute():
            for _ in range(TICKS - 1):
                simulation.step()

        benchmark.pedantic(minute, rounds=9, warmup_rounds=1)
        process.end({})
        process.wait()
    benchmark.extra_info["steps per round"] = TICKS - 1


@pytest.mark.parametrize("beside", ["nothing", "live"])
def test_a_step_in_real_time(benchmark, dynamic, tmp_path, beside):
    """From the moment a tick is due to its complete row, at 10 ticks per second, with a recording and a live stream."""
    write_system(dynamic, tmp_path)
    late = []
    with (
        LiveStream(LiveOptions(viewer=False), lambda _: None) as stream,
        RecordingProcess() as process,
        Simulation(dynamic.system, h=0.1, until=60.0) as simulation,
    ):
        for each in (process, stream) if beside == "live" else ():
            each.begin(RecordingRequest(tmp_path, tmp_path / "x.rrd", simulation.log.elements, {}), simulation)
            each.wait_until_open()
        pacer, ticks = Pacer(1.0, 0.1), iter(range(600))

        def step():
            tick = next(ticks)
            pacer.wait(tick)
            began = time.perf_counter()
            simulation.step()
            late.append(time.perf_counter() - began)

        benchmark.pedantic(step, rounds=200)
        for each in (process, stream):
            each.end({})
            each.wait()
    benchmark.extra_info["99th percentile [us]"] = float(np.percentile(late, 99) * 1e6)
    benchmark.extra_info["budget"] = BUDGET
