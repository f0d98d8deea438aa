"""What the pictures are made of."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest

from orchestrator.pictures import drawing
from orchestrator.pictures.drawing import Boxes
from orchestrator.pictures.signals import SignalColumns, signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.shown import shown


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


def _traffic_rows(valid, x):
    """Rows of a traffic unit with eight slots."""
    columns = {"time": np.arange(len(valid)) * 0.1}
    for slot in range(8):
        at = f"[{slot + 1}]"
        columns[f"traffic.obstacles.valid{at}"] = np.array(valid)[:, slot]
        columns[f"traffic.obstacles.id{at}"] = slot + 1
        columns[f"traffic.obstacles.x{at}"] = np.array(x, dtype=float)
        for name, value in (("y", 0.0), ("psi", 0.0), ("v", 0.0), ("length", 4.0), ("width", 2.0)):
            columns[f"traffic.obstacles.{name}{at}"] = value
    return pd.DataFrame(columns)


def test_obstacles_of_invalid_slots_are_left_out(static):
    valid = [[True, False, True] + [False] * 5, [False] * 8, [False, True] + [False] * 6]
    columns = SignalColumns(_traffic_rows(valid, [10.0, 20.0, 30.0]), signals(static.system))
    boxes, known = drawing.obstacles(columns, shown(static.system))
    assert boxes.count.tolist() == [2, 0, 1]
    assert boxes.id.tolist() == [1, 3, 2]
    assert boxes.x.tolist() == [10.0, 10.0, 30.0]
    assert known.shape[0] == 3
    last = boxes.where(np.array([False, True, True]))
    assert (last.count.tolist(), last.row.tolist(), last.id.tolist()) == ([0, 1], [1], [2])
    one = boxes.only(boxes.id == 2)
    assert (one.count.tolist(), one.row.tolist(), one.x.tolist()) == ([0, 0, 1], [2], [30.0])


def test_an_obstacle_is_the_same_in_any_slot(static):
    valid = [[True, True] + [False] * 6, [True, True] + [False] * 6]
    rows = _traffic_rows(valid, [10.0, 20.0])
    rows["traffic.obstacles.x[2]"] = [12.0, 22.0]
    rows["traffic.obstacles.id[1]"], rows["traffic.obstacles.id[2]"] = [4, 9], [9, 7]
    boxes, _ = drawing.obstacles(SignalColumns(rows, signals(static.system)), shown(static.system))
    assert boxes.id.tolist() == [4, 9, 9, 7]
    assert boxes.only(boxes.id == 9).x.tolist() == [12.0, 20.0]


def test_a_boundary_shows_where_the_box_is_heading():
    quarter = Boxes.of(*(np.array([v]) for v in (10.0, 2.0, np.pi / 2, 4.0, 2.0)))
    line = drawing.boundaries(quarter, 0.5)[0]
    np.testing.assert_allclose(line[0], [10, 2])
    np.testing.assert_allclose(line[1], [10, 4.5])
    np.testing.assert_allclose(line[[2, 3, 4, 5, 2]], drawing.outlines(quarter, 0.5)[0])


def test_an_outline_is_the_box_grown_on_every_side():
    quarter = Boxes.of(*(np.array([v]) for v in (10.0, 2.0, np.pi / 2, 4.0, 2.0)))
    corners = drawing.outlines(quarter, 0.5)[0]
    np.testing.assert_allclose(corners[0], corners[-1])
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [[8.5, -0.5], [11.5, 4.5]])


def test_waypoints_on_one_spot_share_a_label():
    x = np.array([0.0, 1.0, 1.0, 1.0, 2.0])
    assert drawing.waypoint_labels(x, np.zeros(5)) == ["P0", "P1,2,3", "", "", "P4"]
    rows = np.array([[0.0, 0.004], [1.0, 2.0], [np.nan, np.nan]])
    assert drawing.waypoint_labels(rows, np.zeros((3, 2))) == ["P0,1", "", "P0", "P1", "P0", "P1"]
    assert drawing.waypoint_labels(rows, rows[::-1]) == ["P0", "P1"] * 3


def test_the_error_is_drawn_from_green_to_red_whatever_its_sign():
    colours = drawing.error_colours(np.array([0.0, 9.0, -9.0]))
    assert colours[0].argmax() == 1
    assert colours[1].argmax() == 0
    np.testing.assert_array_equal(colours[1], colours[2])


def test_lane_marks_stay_between_the_lanes(static):
    marks = drawing.lane_marks(static.scene, -40.0, 140.0)
    assert (marks[..., 1] == 1.75).all()
    assert -40 <= marks[..., 0].min() <= marks[..., 0].max() <= 140


def test_a_third_lane_has_a_mark_of_its_own(static):
    one = drawing.lane_marks(static.scene, -40.0, 140.0)
    both = drawing.lane_marks(dataclasses.replace(static.scene, y_third=-3.5, y_right=-5.25), -40.0, 140.0)
    assert len(both) == 2 * len(one)
    assert set(both[..., 1].ravel()) == {1.75, -1.75}
