"""Recordings, read back with Rerun's own reader, and once in the real viewer."""

from __future__ import annotations

import io
import socket
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun_cli
from PIL import Image
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from orchestrator import pictures
from orchestrator.master import Simulation
from orchestrator.rerun_stream import RerunStream
from orchestrator.scenario import Options, Scenario, prepare
from orchestrator.system import System

DRIVER = Path("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json")
EGO = (70, 150, 255)


@pytest.fixture(autouse=True)
def strict():
    """Values that Rerun cannot take are errors, not warnings."""
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


def _run(scenario, until):
    with Simulation(scenario.system, h=scenario.h, until=until) as simulation:
        simulation.run()
        return simulation.frame(), simulation.step_times


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


@pytest.fixture(scope="module")
def rows(static: Scenario):
    return _run(static, 11.3)


def _record(path, system, scene, frame, times, batches=1):
    stream = RerunStream(path, system, scene, name="a run", h=0.1, about={"scenario": "static", "version": "0.0"})
    for part in np.array_split(np.arange(len(frame)), batches):
        stream.log(frame.iloc[part], times[part])
    stream.close()
    return _read(path)


def _read(path):
    """All components by entity: (is it static, rows of the component with their ticks)."""
    found = defaultdict(list)
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        ticks = [None] * batch.num_rows if chunk.is_static else batch.column("tick").to_pylist()
        for name in batch.schema.names:
            if ":" in name or name == "sim_time":
                values = batch.column(name)
                values = values.cast("int64").to_pylist() if name == "sim_time" else values.to_pylist()
                found[chunk.entity_path, name] += list(zip(ticks, values, strict=True))
    return {key: sorted(values, key=lambda item: -1 if item[0] is None else item[0]) for key, values in found.items()}


@pytest.fixture(scope="module")
def recorded(static, rows, tmp_path_factory):
    return _record(tmp_path_factory.mktemp("recording") / "run.rrd", static.system, static.scene, *rows)


def test_every_signal_is_recorded_exactly(recorded, static, rows):
    frame, _ = rows
    for signal in pictures.signals(static.system):
        entity = "/signals/" + signal.path.replace(".", "/")
        found = recorded[entity, "Scalars:scalars"]
        assert [tick for tick, _ in found] == list(range(len(frame)))
        expected = frame[list(signal.columns)].to_numpy(dtype=float)
        np.testing.assert_array_equal(np.array([values for _, values in found]), expected)


def test_time_is_tick_times_step_to_the_nanosecond(recorded, rows):
    assert recorded["/signals/plant/state/x", "sim_time"] == [(k, k * 100_000_000) for k in range(len(rows[0]))]


def test_series_carry_their_units(recorded):
    assert recorded["/signals/plant/state/v_x", "SeriesLines:names"] == [(None, ["v_x [m/s]"])]
    names = recorded["/signals/controller/plan/x", "SeriesLines:names"][0][1]
    assert names == ["x[1] [m]", "x[2] [m]", "x[3] [m]"]


def test_wall_time_states_limits_and_path_error_are_there(recorded, rows):
    times = [values[0] for _, values in recorded["/performance/step_time", "Scalars:scalars"]]
    np.testing.assert_array_equal(times, rows[1] * 1e6)
    assert recorded["/states/controller/solver/status", "StateChange:state"] == [(0, ["converged"])]
    assert recorded["/limits/controller/actuation/T_r/lower", "Scalars:scalars"] == [(0, [-160.0]), (113, [-160.0])]
    error = [values[0] for _, values in recorded["/derived/path_error", "Scalars:scalars"]]
    assert len(error) == len(rows[0])
    assert 0.1 < np.abs(error).max() < 1


def test_the_road_stands_once_and_reaches_beyond_the_run(recorded, static, rows):
    (_, edges), *more = recorded["/world/road/edges", "LineStrips3D:strips"]
    assert not more
    x, y, _ = np.array(edges).reshape(-1, 3).T
    assert x.min() < 0
    assert x.max() > rows[0]["plant.state.x"].max()
    assert set(y.tolist()) == {static.scene.y_left, static.scene.y_right}


def test_still_obstacles_are_sent_once_and_only_those_that_are_valid(recorded):
    ((tick, centres),) = recorded["/world/obstacles/footprint", "Boxes3D:centers"]
    assert tick == 0
    np.testing.assert_allclose([c[:2] for c in centres], [[49.5, 0], [92.5, 3.5], [110.5, 3.5]])
    ((_, labels),) = recorded["/world/obstacles/boundary", "LineStrips3D:labels"]
    assert labels == ["#1", "#2", "#3"]


def test_an_obstacle_that_goes_is_cleared(static, rows, tmp_path):
    frame = rows[0].head(6).copy()
    frame["traffic.obstacles.valid[1]"] = [True, True, False, False, False, False]
    for slot in (2, 3):
        frame[f"traffic.obstacles.valid[{slot}]"] = [True, True, True, True, False, False]
    found = _record(tmp_path / "run.rrd", static.system, static.scene, frame, rows[1][:6])
    for entity in ("footprint", "body"):
        counts = [(tick, len(c)) for tick, c in found[f"/world/obstacles/{entity}", "Boxes3D:centers"]]
        assert counts == [(0, 3), (2, 2), (4, 0)]
    boundary = found["/world/obstacles/boundary", "LineStrips3D:strips"]
    assert [(tick, len(strips)) for tick, strips in boundary] == [(0, 3), (2, 2), (4, 0)]


def test_batches_make_the_same_recording_as_one(static, rows, recorded, tmp_path):
    found = _record(tmp_path / "run.rrd", static.system, static.scene, *rows, batches=5)
    assert found.keys() == recorded.keys()
    for key, values in recorded.items():
        # limits are drawn from the first to the last row of each batch; the properties hold the date of the recording
        if not key[0].startswith(("/limits", "/__properties")):
            assert found[key] == values, key


def test_a_system_without_sockets_shows_its_signals(static, rows, tmp_path):
    plain = System(units=static.system.units, wiring=static.system.wiring)
    found = _record(tmp_path / "run.rrd", plain, static.scene, *rows)
    entities = {entity for entity, _ in found}
    assert "/signals/plant/state/x" in entities
    assert not any(entity.startswith("/world") for entity in entities)


def test_a_scenario_of_empty_plugs_is_recorded(tmp_path):
    idle = prepare("idle", Options(mode="blocks"))
    found = _record(tmp_path / "run.rrd", idle.system, idle.scene, *_run(idle, 1.0))
    entities = {entity for entity, _ in found}
    assert {"/world/ego", "/world/trail", "/signals/plant/state/x"} <= entities
    assert not entities & {"/world/plan", "/derived/path_error", "/limits/plant/tyre/mu_f/upper"}


def test_units_without_a_scene_and_runs_that_broke_are_recorded(static, rows, tmp_path):
    frame = rows[0].head(3).copy()
    frame.loc[2, "plant.state.x"] = np.inf
    frame.loc[2, "plant.state.y"] = np.nan
    frame.loc[2, "controller.plan.x[3]"] = 1e300
    assert _record(tmp_path / "broken.rrd", static.system, static.scene, frame, rows[1][:3])
    found = _record(tmp_path / "bare.rrd", static.system, None, frame.head(1), rows[1][:1])
    assert ("/signals/plant/state/x", "Scalars:scalars") in found
    assert not any(entity.startswith("/world") for entity, _ in found)


def test_rows_that_are_missing_leave_out_what_needs_them(static, rows, tmp_path):
    frame = rows[0][["time", "plant.state.x", "plant.state.r"]]
    found = _record(tmp_path / "run.rrd", static.system, static.scene, frame, rows[1])
    assert ("/signals/plant/state/r", "Scalars:scalars") in found
    assert ("/world/ego", "Transform3D:translation") not in found


def test_the_page_about_the_run_is_readable(recorded):
    ((_, (text,)),) = recorded["/about", "TextDocument:text"]
    assert text == "# a run\n\n| | |\n|---|---|\n| scenario | static |\n| version | 0.0 |\n"


@pytest.mark.viewer
@pytest.mark.skipif(
    not DRIVER.exists(), reason="no software Vulkan driver: apt-get install mesa-vulkan-drivers libvulkan1"
)
def test_the_viewer_shows_the_scene(static, rows, tmp_path, monkeypatch):
    monkeypatch.setenv("VK_ICD_FILENAMES", str(DRIVER))
    path = tmp_path / "run.rrd"
    _record(path, static.system, static.scene, *rows)
    picture = np.asarray(Image.open(io.BytesIO(_photograph(path, 2.6))).convert("RGB")).astype(int)
    upper = picture[: picture.shape[0] // 2]
    for colour in (EGO, (190, 145, 255), (215, 95, 45)):  # the vehicle, its path, an obstacle
        assert (np.abs(upper - colour).max(axis=-1) < 12).sum() > 50, colour
    lower = picture[picture.shape[0] // 2 :].reshape(-1, 3)
    assert len(np.unique(lower // 8, axis=0)) > 50


def _photograph(recording, t):
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port = found.getsockname()[1]
    # the native binary: the Python wrapper would leave the viewer running
    viewer = str(Path(rerun_cli.__file__).with_name("rerun"))
    with ViewerClient.spawn(headless=True, port=port, hide_welcome_screen=True, executable_path=viewer) as client:
        client.open(str(recording))
        deadline = time.monotonic() + 60
        while not client.get_state().recordings and time.monotonic() < deadline:
            time.sleep(0.1)
        client.set_time("sim_time", duration=t, play_state="paused")
        time.sleep(2)
        return client.take_screenshot()
