"""The recording of a run: in many small batches while it steps, in few large ones in the end."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
from rerun.chunk import RrdReader

from orchestrator.recording.messages import RecordingRequest
from orchestrator.recording.recording import LARGE, Afterwards, Recording, joined
from orchestrator.results.parquet import write_signals
from orchestrator.results.run_folder import write_system
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import EVERYTHING

ABOUT = {"status": "finished"}
# a file that is still being written has no footer, and Rerun says so
pytestmark = pytest.mark.filterwarnings("ignore:RRD file has no footer")


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


def stepped(scenario, until, record=EVERYTHING):
    with Simulation(scenario.system, h=scenario.h, until=until, record=record) as simulation:
        simulation.run()
        return simulation


def request(simulation, folder):
    return RecordingRequest(folder, folder / "recording.rrd", simulation.log.elements, {"status": "running"})


def values(path):
    """What was recorded of each signal, as {tick: values}."""
    found = defaultdict(dict)
    for chunk in RrdReader(path).stream():
        if chunk.entity_path.startswith("/signals/") and not chunk.is_static:
            batch = chunk.to_record_batch()
            rows = dict(zip(batch.column("tick").to_pylist(), batch.column("Scalars:scalars").to_pylist(), strict=True))
            assert not found[chunk.entity_path].keys() & rows.keys(), "a row twice"
            found[chunk.entity_path].update(rows)
    return found


def status(path):
    pages = [c.to_record_batch() for c in RrdReader(path).stream() if c.entity_path == "/about"]
    return str(pages[-1].column("TextDocument:text").to_pylist()[-1])


def test_a_slow_run_is_on_disk_as_it_goes_and_tidy_in_the_end(static, tmp_path):
    simulation = stepped(static, 6.0)
    recording = Recording(request(simulation, tmp_path), static)
    for first in range(0, 61, 5):
        recording.log(simulation.log.batches(first, min(first + 5, 61), simulation.step_times))
        seen = values(tmp_path / "recording.rrd")["/signals/plant/state/x"]
        assert max(seen) == min(first + 4, 60)
    large = (tmp_path / "recording.rrd").stat().st_size
    recording.close(ABOUT)
    assert [p.name for p in tmp_path.iterdir()] == ["recording.rrd"]
    once = tmp_path / "once"
    once.mkdir()
    whole = Recording(request(simulation, once), static)
    whole.log(simulation.log.batches(0, 61, simulation.step_times), last=True)
    whole.close(ABOUT)
    assert values(tmp_path / "recording.rrd") == values(once / "recording.rrd")
    size = (tmp_path / "recording.rrd").stat().st_size
    assert abs(size - (once / "recording.rrd").stat().st_size) < 10_000
    assert size < 0.75 * large  # which has the layout as well, without the ranges of the axes
    assert "finished" in status(tmp_path / "recording.rrd")


def test_a_fast_run_is_written_once(static, tmp_path):
    simulation = stepped(static, 40.0)
    recording = Recording(request(simulation, tmp_path), static)
    recording.log(simulation.log.batches(0, 300, simulation.step_times))
    recording.log(simulation.log.batches(300, 401, simulation.step_times))
    assert [p.name for p in tmp_path.iterdir()] == ["recording.rrd"]
    recording.close(ABOUT)
    assert len(values(tmp_path / "recording.rrd")["/signals/plant/state/x"]) == 401


def test_afterwards_all_rows_are_written_with_what_is_known_of_the_run(static, tmp_path):
    write_system(static, tmp_path)
    simulation = stepped(static, 2.0)
    afterwards = Afterwards()
    afterwards.begin(request(simulation, tmp_path), simulation)
    afterwards.wait_until_open()
    afterwards.end({"status": "fault"})
    assert afterwards.wait() == ""
    found = values(tmp_path / "recording.rrd")
    frame = simulation.frame()
    np.testing.assert_array_equal([row[0] for row in found["/signals/plant/state/x"].values()], frame["plant.state.x"])
    assert "fault" in status(tmp_path / "recording.rrd")


def test_signals_with_ticks_of_their_own_have_rows_of_their_own(static, tmp_path):
    simulation = stepped(static, 3.0, {"plant.*": 1, "controller.plan.*": 5, "controller.solver.*": 3})
    recording = Recording(request(simulation, tmp_path), static)
    for first in range(0, 31, 4):
        recording.log(simulation.log.batches(first, min(first + 4, 31), simulation.step_times))
    recording.close(ABOUT)
    found = values(tmp_path / "recording.rrd")
    assert sorted(found["/signals/plant/state/x"]) == list(range(31))
    assert sorted(found["/signals/controller/plan/x"]) == list(range(0, 31, 5))
    assert sorted(found["/signals/controller/solver/kkt"]) == list(range(0, 31, 3))
    assert not any(entity.startswith("/signals/traffic") for entity in found)


def test_batches_are_joined_group_by_group_up_to_a_size(static):
    simulation = stepped(static, 100.0, {"plant.*": 1, "controller.*": 7})
    pieces = []
    for first in range(0, 1001, 3):
        pieces += simulation.log.batches(first, min(first + 3, 1001), simulation.step_times)
    whole = joined(pieces)
    assert [(b.group, b.first) for b in whole] == [(0, 0), (0, 600), (1, 0)]
    assert [len(b) for b in whole] == [LARGE, 401, 143]
    for group, expected in enumerate(simulation.log.batches(0, 1001, simulation.step_times)):
        parts = [b for b in whole if b.group == group]
        np.testing.assert_array_equal(np.concatenate([b.ticks for b in parts]), expected.ticks)
        for kind, rows in expected.blocks.items():
            np.testing.assert_array_equal(np.concatenate([b.blocks[kind] for b in parts]), rows)


def test_a_simulated_minute_of_everything_is_two_mebibytes_at_most(tmp_path):
    made = prepare("dynamic", Options(mode="blocks"))  # whose obstacles move at every tick
    simulation = stepped(made, 60.0)
    write_signals(simulation.columns(), made, tmp_path / "signals.parquet")
    recording = Recording(request(simulation, tmp_path), made)
    for first in range(0, 601, 5):  # as they come in real time
        recording.log(simulation.log.batches(first, min(first + 5, 601), simulation.step_times))
    recording.close(ABOUT)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["recording.rrd", "signals.parquet"]
    size = sum(path.stat().st_size for path in tmp_path.iterdir())
    assert size < 2 * 2**20
