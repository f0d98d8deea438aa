"""The figures of a run, and the parts that they consist of (`figure_parts.py`)."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from orchestrator.pictures.figure_parts import instants, sheet, vehicles
from orchestrator.pictures.figures import draw
from orchestrator.pictures.signals import SignalColumns, signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.shown import shown
from orchestrator.system.system import System


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


@pytest.fixture(scope="module")
def rows(static):
    return simulate(static.system, h=static.h, until=static.until)


def _colours(path):
    return np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3).astype(int)


def test_all_figures_of_the_static_scenario(static, rows, tmp_path):
    files = draw(rows, static.system, static.scene, tmp_path / "figures")
    assert [f.name for f in files] == [
        "trajectory.png",
        "actuation.png",
        "yaw_rate.png",
        "acceleration.png",
        "friction.png",
        "speed.png",
        "path_error.png",
    ]
    pixels = _colours(files[0])
    for colour in ((31, 111, 209), (209, 96, 42), (138, 92, 201)):  # driven, obstacles, path
        assert (np.abs(pixels - colour).max(axis=1) < 12).sum() > 100


def test_nothing_is_cut_off(static, rows, tmp_path):
    for file in draw(rows, static.system, static.scene, tmp_path):
        picture = np.asarray(Image.open(file).convert("L"))
        for edge in (picture[0], picture[-1], picture[:, 0], picture[:, -1]):
            assert edge.min() == 255, file.name


def test_a_vehicle_that_diverges_is_drawn_up_to_where_it_leaves_the_road(static, tmp_path):
    time = np.arange(0, 5000, 0.1)
    frame = {
        "time": time,
        "plant.state.x": 1e-3 * np.exp(np.minimum(time, 600)),
        "plant.state.y": 1e200 * (time > 30),
    }
    frame["plant.state.psi"] = np.zeros_like(time)
    (file,) = draw(frame, static.system, static.scene, tmp_path)
    assert len(_colours(file)) < 2000**2


def _drawn(scenario, frame, until):
    """A panel with the vehicles in it."""
    axes = sheet(2.0, 1)[1][0]
    axes.set(xlim=(-50, until), ylim=(-3, 6))
    columns = SignalColumns(frame, signals(scenario.system))
    vehicles(axes, columns, shown(scenario.system), scenario.scene)
    return axes


def _boxes(axes, channel):
    """The filled boxes of a panel whose strongest colour is a channel: red for obstacles, blue for the vehicle."""
    return [p for p in axes.patches if p.get_fill() and np.argmax(p.get_facecolor()[:3]) == channel]


def test_a_long_run_has_a_bounded_number_of_boxes(static):
    time = np.arange(0, 1e5, 1.0)
    rows, pause = instants(time)
    assert (len(rows), pause) == (200, 500)
    frame = {"time": time, "plant.state.x": time, "plant.state.y": 0 * time, "plant.state.psi": 0 * time}
    axes = _drawn(static, frame, 1e5)
    assert len(axes.patches) == 200
    assert axes.get_legend_handles_labels()[1] == ["ego, every 500 s"]
    assert not axes.texts  # none would fit


@pytest.mark.parametrize("name", ["dynamic", "dynamic-slow"])
def test_obstacles_that_move_are_drawn_where_they_were_at_the_egos_times(name):
    scenario = prepare(name, Options(mode="blocks"))
    frame = simulate(scenario.system, h=scenario.h, until=6.0)
    axes = _drawn(scenario, frame, 79)
    at = frame[np.isclose(frame["time"] % 1, 0) | np.isclose(frame["time"] % 1, 1)]
    assert len(at) == 7
    centres = [np.mean(box.get_xy()[:4], axis=0) for box in _boxes(axes, 0)]
    expected = [at[[f"traffic.obstacles.{axis}[{i}]" for axis in "xy"]] for i in (1, 2, 3)]
    np.testing.assert_allclose(centres, np.concatenate(expected))
    own = [np.mean(box.get_xy()[:4], axis=0) for box in _boxes(axes, 2)]
    np.testing.assert_allclose(own, at[["plant.state.x", "plant.state.y"]])
    written = {text.get_text() for text in axes.texts}
    assert {f"{second} s" for second in range(7)} | {f"#1, {second} s" for second in range(4)} <= written


def test_no_box_of_the_ego_lies_under_that_of_an_obstacle():
    scenario = prepare("dynamic", Options(mode="blocks"))
    axes = _drawn(scenario, simulate(scenario.system, h=scenario.h, until=scenario.until), 150)
    own = _boxes(axes, 2)
    others = [patch for patch in axes.patches if patch not in own]
    assert len(own) == 12
    assert len(others) == 3 * 12 + 3  # three obstacles, each with its safety boundary
    assert min(p.get_zorder() for p in own) > max(p.get_zorder() for p in others)
    strengths = [p.get_edgecolor()[3] for p in own]
    assert strengths == sorted(strengths)
    assert strengths[0] > 0.4  # the first one is still to be seen


def test_obstacles_that_stand_still_are_drawn_once(static, rows):
    axes = _drawn(static, rows, 79)
    assert len(_boxes(axes, 0)) == 3
    assert {"1", "2", "3", "0 s"} <= {text.get_text() for text in axes.texts}
    assert axes.get_legend_handles_labels()[1] == ["obstacle", "safety boundary", "ego, every 1 s"]


def test_obstacles_that_leave_and_enter_the_bus_are_drawn_once_each():
    made = prepare("dense", Options(mode="blocks"))
    axes = _drawn(made, simulate(made.system, h=made.h, until=made.until), 1e4)
    assert len(_boxes(axes, 0)) == 20
    assert {text.get_text() for text in axes.texts} >= set(map(str, range(1, 21)))


def test_a_system_without_sockets_has_no_figures(static, rows, tmp_path):
    plain = System(units=static.system.units, wiring=static.system.wiring)
    assert draw(rows, plain, static.scene, tmp_path / "figures") == []
    assert not (tmp_path / "figures").exists()


def test_what_is_not_there_is_not_drawn(tmp_path):
    idle = prepare("idle", Options(mode="blocks"))
    files = draw(simulate(idle.system, h=0.1, until=1.0), idle.system, idle.scene, tmp_path)
    assert [f.name for f in files] == ["trajectory.png", "actuation.png", "yaw_rate.png", "speed.png"]


@pytest.mark.parametrize("n", [1, 3])
def test_a_run_that_broke_is_drawn(static, rows, tmp_path, n):
    frame = rows.head(n + 1).copy()
    frame.loc[n, "plant.state.x"] = np.nan
    frame.loc[n, "plant.state.y"] = 1e30
    assert draw(frame, static.system, static.scene, tmp_path)
    assert draw(frame.head(1), static.system, static.scene, tmp_path)
