"""The corridor of the paper's road (edges -1.75 and 5.25, gap 0.35, ramps of 6 m) at chosen stations."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controller.corridor import Road, corridor

ROAD = Road(y_left=5.25, y_right=-1.75, l_gap=0.35, l_ramp=6.0)
OWN, ADJACENT = {"x": 50.0, "y": 0.0}, {"x": 50.0, "y": 3.5}


def free(slots, x: float, t: float = 0.0) -> tuple[float, float]:
    upper, lower = corridor(ROAD, slots, x, t)
    return float(upper), float(lower)


@given(x=st.floats(-1e3, 1e3), t=st.floats(0, 10))
def test_an_empty_road_is_free_from_edge_to_edge(obstacles, x, t):
    assert free(obstacles(), x, t) == (5.25, -1.75)


@pytest.mark.parametrize(
    ("x", "lower"),
    [
        (50.0, 1.25),  # beside the box: 0 + 1.8 / 2 + 0.35
        (47.35, 1.25),  # the last station of the box with its gap: 4.6 / 2 + 0.35 before the centre
        (52.65, 1.25),
        (44.35, -0.25),  # half-way down the ramp
        (55.65, -0.25),
        (45.85, 0.5),  # three quarters up
        (41.35, -1.75),  # end of the ramp
        (58.65, -1.75),
        (30.0, -1.75),
    ],
)
def test_an_obstacle_in_the_right_lane_pushes_the_right_edge(obstacles, x, lower):
    assert free(obstacles(OWN), x) == pytest.approx((5.25, lower), abs=1e-12)


@pytest.mark.parametrize(("x", "upper"), [(50.0, 2.25), (52.65, 2.25), (55.65, 3.75), (44.35, 3.75), (58.65, 5.25)])
def test_an_obstacle_in_the_left_lane_pushes_the_left_edge(obstacles, x, upper):
    assert free(obstacles(ADJACENT), x) == pytest.approx((upper, -1.75), abs=1e-12)


def test_of_several_obstacles_the_one_that_leaves_less_counts(obstacles):
    slots = obstacles(OWN, {"x": 50.0, "y": -0.5}, ADJACENT, {"x": 56.0, "y": 3.0})
    assert free(slots, 50.0) == pytest.approx((2.25, 1.25), abs=1e-12)
    # at 56 m: the last obstacle is beside; of the one at 50 m the ramp is left by (8.65 - 6) / 6
    assert free(slots, 56.0) == pytest.approx((1.75, -1.75 + 3.0 * 2.65 / 6), abs=1e-12)


def test_an_obstacle_moves_on_at_its_speed_along_its_heading(obstacles):
    slots = obstacles({**OWN, "v": 5.0})
    assert free(slots, 60.0, 2.0) == pytest.approx((5.25, 1.25), abs=1e-12)
    assert free(slots, 50.0, 2.0) == pytest.approx((5.25, -1.75), abs=1e-12)
    oncoming = obstacles({**ADJACENT, "v": 5.0, "psi": math.pi})
    assert free(oncoming, 40.0, 2.0) == pytest.approx((2.25, -1.75), abs=1e-12)


def test_an_empty_slot_pushes_nothing(obstacles):
    assert free(obstacles({**OWN, "valid": 0.0}), 50.0) == (5.25, -1.75)
    assert free(obstacles({**OWN, "valid": 0.0}, ADJACENT), 50.0) == pytest.approx((2.25, -1.75), abs=1e-12)


@pytest.mark.parametrize("y", [-8.0, 12.0])
def test_an_obstacle_beside_the_road_pushes_nothing(obstacles, y):
    assert free(obstacles({"x": 50.0, "y": y}), 50.0) == (5.25, -1.75)


@given(x=st.floats(30, 70), y=st.floats(-3, 7), length=st.floats(0, 20), width=st.floats(0, 3))
def test_the_corridor_never_reaches_beyond_the_road_nor_into_a_box(obstacles, x, y, length, width):
    upper, lower = free(obstacles({"x": 50.0, "y": y, "length": length, "width": width}), x)
    assert upper <= 5.25
    assert lower >= -1.75
    inside = abs(x - 50.0) <= length / 2
    if inside and y > 1.75:
        assert upper <= y - width / 2
    elif inside:
        assert lower >= y + width / 2


def test_an_obstacle_pushes_in_the_edge_on_its_side_of_the_line_that_is_given(obstacles):
    """On a road with three lanes the change to the right one passes the own lane's obstacle on its right."""
    road = Road(y_left=5.25, y_right=-5.25, l_gap=0.35, l_ramp=6.0)
    seen = obstacles(OWN, ADJACENT, {"x": 50.0, "y": -3.5})
    assert corridor(road, seen, 50.0, 0.0, -1.75) == pytest.approx((-1.25, -2.25))
    assert corridor(road, seen, 50.0, 0.0, 1.75) == pytest.approx((2.25, 1.25))
