"""The verdict whether a vehicle has done what it was on the road for."""

from __future__ import annotations

import json

import numpy as np
import pytest

from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from orchestrator.results.task import is_done, start_remarks, task
from orchestrator.system.scene import Scene

SCENE = Scene(
    ego_length=4.0, ego_width=2.0, y_left=5.0, y_right=-2.0, y_lane=0.0, y_adjacent=3.5, y_third=1e6, l_gap=0.3
)
BUSES = {VehicleState: "car.state", ObstacleList: "others.obstacles"}
TIME = np.arange(11.0)


def rows(v=10.0, y_end=0.0, obstacles=()):
    """Ten seconds at a speed; obstacles are a place along the road, one across it, and a speed."""
    columns = {
        "time": TIME,
        "car.state.x": v * TIME,
        "car.state.y": np.linspace(3.0, y_end, 11),
        "car.state.v_x": np.full(11, v),
    }
    for i in range(SLOTS):
        x, y, speed = obstacles[i] if i < len(obstacles) else (0.0, 0.0, 0.0)
        columns |= {
            f"others.obstacles.valid[{i + 1}]": np.full(11, float(i < len(obstacles))),
            f"others.obstacles.id[{i + 1}]": np.full(11, float(i + 1)),
            f"others.obstacles.x[{i + 1}]": x + speed * TIME,
            f"others.obstacles.y[{i + 1}]": np.full(11, y),
        }
    return columns


@pytest.mark.parametrize(
    ("frame", "done"),
    [
        (rows(), True),
        (rows(obstacles=[(50, 0, 0), (80, 3.5, 0)]), True),
        (rows(obstacles=[(150, 0, 0)]), True),  # out of reach
        (rows(obstacles=[(50, 0, 12)]), True),  # faster
        (rows(v=0.0), False),
        (rows(v=0.0, obstacles=[(50, 0, 0)]), False),
        (rows(v=4.0, obstacles=[(50, 0, 0)]), False),  # behind somebody, and slow
        (rows(y_end=3.5, obstacles=[(50, 0, 0)]), False),  # not back
    ],
)
def test_who_is_slower_is_passed_and_the_vehicle_is_back_and_at_speed(frame, done):
    assert is_done(task(frame, BUSES, SCENE, 10.0)) == {"task_done": done}


def test_the_metrics_of_the_task():
    found = task(rows(v=9.5, y_end=0.2, obstacles=[(50, 0, 0), (96, 0, 0), (30, 0, 9.5)]), BUSES, SCENE, 10.0)
    assert found == pytest.approx(
        {
            "lane_offset_end": 0.2,
            "speed_share_end": 0.95,
            "speed_share_start": 0.95,
            "obstacles_to_pass": 2,
            "obstacles_passed": 1,
        }
    )
    until = task(rows(y_end=1e300), BUSES, SCENE, None, until=1)
    assert until == {"lane_offset_end": 3.0, "speed_share_end": 1.0, "obstacles_to_pass": 0, "obstacles_passed": 0}


def test_an_obstacle_is_the_same_in_any_slot_and_may_come_into_sight_later():
    """One at 50 m is overtaken and no longer seen; one at 80 m comes into sight in its slot."""
    frame = rows(obstacles=[(50, 0, 0)])
    frame["others.obstacles.id[1]"] = np.where(TIME < 6, 1.0, 2.0)
    frame["others.obstacles.x[1]"] = np.where(TIME < 6, 45.0, 80.0)
    found = task(frame, BUSES, SCENE, 10.0)
    assert (found["obstacles_to_pass"], found["obstacles_passed"]) == (2, 2)
    del frame["others.obstacles.id[1]"], frame["others.obstacles.id[8]"]
    assert "obstacles_passed" not in task(frame, BUSES, SCENE, 10.0)


def test_without_a_vehicle_there_is_no_task():
    assert task({"time": TIME}, BUSES, SCENE, 10.0) == {}
    assert task({name: np.full(11, np.nan) for name in rows()}, BUSES, SCENE, 10.0) == {}
    assert is_done({"gap_edge": 1.0}) == {}


def test_a_car_that_never_moves_has_not_done_it(macrostep, without_pictures, tmp_path):
    still = ("--controller", "coast", "--set", "plant.v_x_start=0", "--stop-time", 2, "--blocks", "--out", "r")
    code, out, _ = macrostep("run", "static", *still)
    assert code == 0
    assert "task done               no" in out
    assert json.loads((tmp_path / "r" / "summary.json").read_text())["verdicts"]["task_done"] is False


@pytest.mark.parametrize(
    ("share", "plant", "kind", "told"),
    [
        (0.0, "plant", "Theirs", True),
        (1.5, "plant", "Theirs", True),
        (0.9, "plant", "Theirs", False),
        (0.0, "plant", "bicycle", False),  # starts as its parameters say
        (0.0, None, "", False),
    ],
)
def test_a_start_at_another_speed_than_the_controllers_is_told(share, plant, kind, told):
    remarks = start_remarks({"speed_share_start": share}, plant, kind)
    assert len(remarks) == told
    if told:
        assert remarks[0].startswith(f"`plant` starts at {share:.0%} of the speed that its controller is asked for")
