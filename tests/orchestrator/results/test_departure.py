"""A vehicle that leaves the surroundings of its road is told, and nothing is computed from what follows."""

from __future__ import annotations

import json

import numpy as np
import pytest

from orchestrator.results.departure import departure, in_surroundings
from orchestrator.system.scene import BESIDE_ROAD, ROAD_AT_MOST, Scene

ROAD = Scene(ego_length=4, ego_width=2, y_left=5, y_right=-2, y_lane=0, y_adjacent=3.5, y_third=1e6, l_gap=1)


def test_the_surroundings_end_beside_the_road_and_far_along_it():
    y = np.array([5 + BESIDE_ROAD, 5.1 + BESIDE_ROAD, -2 - BESIDE_ROAD, -2.1 - BESIDE_ROAD, 0, 0, np.nan])
    x = np.array([0, 0, 0, 0, ROAD_AT_MOST[1], ROAD_AT_MOST[1] + 1, 0])
    assert in_surroundings(x, y, ROAD).tolist() == [True, False, True, False, True, False, False]


def test_the_first_place_outside_is_told():
    time, x = np.arange(5) * 0.1, np.arange(5) * 10.0
    y = np.array([0, np.nan, 3, 100, -1e300])
    left = departure(time, x, y, ROAD)
    assert (left.row, left.time, left.x, left.y) == (3, pytest.approx(0.3), 30, 100)
    assert str(left) == "the vehicle left the surroundings of the road at t = 0.3 s, x = 30 m, y = 100 m"
    assert departure(time[:3], x[:3], y[:3], ROAD) is None


def test_a_run_that_diverges_is_told_and_its_numbers_are_bounded(macrostep, without_pictures, tmp_path):
    stiff = ("--set", "plant.I_z=1", "--stop-time", 8, "--blocks", "--out", "r")  # too stiff for the plant's own step
    code, out, err = macrostep("run", "static", *stiff)
    assert code == 1
    assert "note: the vehicle left the surroundings of the road at t = " in " ".join(err.split())
    assert max(map(len, out.splitlines())) < 120
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert summary["departure"]["time"] < 8
    assert max(abs(value) for value in summary["metrics"].values()) <= 1e9


def test_a_run_ends_off_the_road_if_asked_and_repeats_from_its_folder(macrostep, without_pictures, tmp_path):
    runaway = ("--set", "plant.y_start=-9", "--set", "plant.psi_start=-0.5", "--set", "controller.delta_max=0.001")
    code, _, err = macrostep("run", "static", *runaway, "--end-off-road", "--blocks", "--out", "first")
    assert code == 0
    assert "y = -11.8 m; the run ends there" in " ".join(err.split())
    code, _, err = macrostep("run", "first", "--out", "again")
    assert code == 0
    assert "the run ends there" in " ".join(err.split())
    for folder in ("first", "again"):
        summary = json.loads((tmp_path / folder / "summary.json").read_text())
        assert summary["status"] == "finished"
        assert summary["experiment"]["ticks"] == summary["departure"]["row"] + 1 == 7
