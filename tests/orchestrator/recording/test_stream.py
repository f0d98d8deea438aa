"""Recordings, read back with Rerun's own reader, and once in the real viewer."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from orchestrator.pictures.drawing import error_colours, rgba
from orchestrator.pictures.signals import signals
from orchestrator.recording.stream import RerunStream
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import Scenario, TimeGrid
from orchestrator.system.system import System


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
    stream = RerunStream(
        path, system, scene, name="a run", grid=TimeGrid(0.1, 100.0), about={"scenario": "static", "version": "0.0"}
    )
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
    for signal in signals(static.system):
        entity = "/signals/" + signal.path.replace(".", "/")
        found = recorded[entity, "Scalars:scalars"]
        assert [tick for tick, _ in found] == list(range(len(frame)))
        expected = frame[list(signal.columns)].to_numpy(dtype=float)
        np.testing.assert_array_equal(np.array([values for _, values in found]), expected)


def test_time_is_tick_times_step_to_the_nanosecond(recorded, rows):
    assert recorded["/signals/plant/state/x", "sim_time"] == [(k, k * 100_000_000) for k in range(len(rows[0]))]


def test_the_clock_of_the_machine_is_not_recorded(static, rows, tmp_path):
    _record(tmp_path / "run.rrd", static.system, static.scene, rows[0].head(3), rows[1][:3])
    found = [chunk.to_record_batch().schema.names for chunk in RrdReader(tmp_path / "run.rrd").stream()]
    assert any("sim_time" in names for names in found)
    assert not any("log_time" in names for names in found)


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
            assert str(found[key]) == str(values), key  # as text, in which not-a-numbers are equal


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


def test_the_page_about_the_run_says_what_ran_and_with_which_values(recorded, static):
    m = static.system.units["plant"].parameters["m"]
    ((_, (text,)),) = recorded["/about", "TextDocument:text"]
    assert text.startswith("# a run\n\n| | |\n|---|---|\n| scenario | static |\n| version | 0.0 |\n")
    assert f"\n| plant.m | {m} | kg | mass |\n" in text
    assert "\n* controller.actuation.T_r -> plant.actuation.T_r\n" in text


def test_the_vehicle_has_its_size_its_heading_and_its_name(recorded, static):
    for part, height in (("footprint", 0.02), ("body", 1.4)):
        ((_, (half,)),) = recorded[f"/world/ego/{part}", "Boxes3D:half_sizes"]
        np.testing.assert_allclose(half, np.array([static.scene.ego_length, static.scene.ego_width, height]) / 2)
        ((_, (arrow,)),) = recorded[f"/world/ego/{part}/heading", "Arrows3D:vectors"]
        assert arrow[0] > static.scene.ego_length / 2
        assert arrow[1:] == [0, 0]
        assert recorded[f"/world/ego/{part}/name", "Points3D:labels"] == [(None, ["ego"])]


def test_modes_and_events_stand_at_their_ticks(recorded, rows):
    states = recorded["/states/manoeuvre", "StateChange:state"]
    names = ["own lane", "changing out", "adjacent lane", "changing back", "own lane"]
    assert [value for _, (value,) in states] == names
    begun = [(tick, text) for tick, (text,) in recorded["/events", "TextLog:text"] if text.startswith("lane change")]
    assert [tick for tick, _ in begun] == [tick for tick, _ in states[1:3]]
    assert begun[0][1] == f"lane change begun at x = {rows[0]['plant.state.x'][begun[0][0]]:.1f} m"


def test_lines_of_the_log_say_how_bad_it_is(recorded):
    texts, levels = (recorded["/events", f"TextLog:{what}"] for what in ("text", "level"))
    assert [tick for tick, _ in texts] == [tick for tick, _ in levels]
    said = {
        text.partition(":")[0].partition(" at ")[0]: level
        for (_, (text,)), (_, (level,)) in zip(texts, levels, strict=True)
    }
    assert (said["lane change begun"], said["limit active"]) == ("INFO", "WARN")


def test_each_point_of_the_trail_has_the_colour_of_its_error(recorded):
    error = np.array([values[0] for _, values in recorded["/derived/path_error", "Scalars:scalars"]])
    colours = np.array([colour for _, (colour,) in recorded["/world/trail", "Points3D:colors"]], dtype=np.uint32)
    np.testing.assert_array_equal(colours, rgba(error_colours(error)))
    assert len(set(colours.tolist())) > 10


def test_friction_is_drawn_as_a_stroke_per_axle(recorded, rows):
    frame, _ = rows
    strokes = recorded["/friction/now", "LineStrips2D:strips"]
    assert len(strokes) == len(frame)
    tick = int(frame["plant.tyre.mu_r"].argmax())
    front, rear = (np.array(stroke) for stroke in strokes[tick][1])
    assert np.linalg.norm(front[1] - front[0]) == pytest.approx(frame["plant.tyre.mu_f"][tick], rel=1e-6)
    assert np.linalg.norm(rear[1] - rear[0]) == pytest.approx(frame["plant.tyre.mu_r"][tick], rel=1e-6)
    (circles,) = [np.array(strip) for _, strip in recorded["/friction/limit", "LineStrips2D:strips"]]
    np.testing.assert_allclose(np.linalg.norm(circles - circles.mean(axis=1, keepdims=True), axis=-1), 1, atol=0.05)
