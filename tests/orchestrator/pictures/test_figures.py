"""The figures of a run, and the parts that they consist of (`figure_parts.py`)."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from orchestrator.pictures.figure_parts import sheet, vehicle
from orchestrator.pictures.figures import draw
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate
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


def test_a_long_run_has_a_bounded_number_of_boxes(static):
    axes = sheet(2.0, 1)[1][0]
    time = np.arange(0, 1e5, 1.0)
    vehicle(axes, time, (time, 0 * time, 0 * time), static.scene)
    assert 100 <= len(axes.patches) <= 201
    assert axes.patches[0].get_label() == "ego, every 500 s"


def test_a_system_without_sockets_has_no_figures(static, rows, tmp_path):
    plain = System(units=static.system.units, wiring=static.system.wiring)
    assert draw(rows, plain, static.scene, tmp_path) == []


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
