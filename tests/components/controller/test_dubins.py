"""The Dubins path against its geometry: closed formulas, a traced curve, and brute force."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq

from components.controller.dubins import LaneChange, Path, Segment, double_lane_change, radius

R = 100 / (0.5 * 9.81)
THETA = brentq(lambda a: 2 * R * (1 - math.cos(a)) + 4.0 * math.sin(a) - 3.5, 0.0, 1.0, xtol=1e-15)
SHAPE = LaneChange(w=3.5, R=R, l_d=4.0)
LENGTH = 2 * R * math.sin(THETA) + 4.0 * math.cos(THETA)
CORNER = (46.85, 1.25)


def path_of(shape: LaneChange, **changes: float) -> Path:
    places = {"x_0": 0.0, "x_1": 20.0, "x_8": 62.0, "x_14": 120.0, "y_lane": 0.0, **changes}
    return double_lane_change(shape, corner=CORNER, **places)


PATH = path_of(SHAPE)
TOTAL = sum(segment.length for segment in PATH.segments)


def traced(ds: float = 0.005) -> tuple[np.ndarray, np.ndarray]:
    """Arc lengths and points of the same path, by integrating its curvature from P0."""
    arc = R * THETA
    pieces = [(20.0, 0), (arc, 1), (4.0, 0), (arc, -1), (62 - 20 - LENGTH, 0), (arc, -1), (4.0, 0), (arc, 1)]
    pieces.append((120 - 62 - LENGTH, 0))
    ends = np.cumsum([length for length, _ in pieces])
    s = np.unique(np.concatenate([np.arange(0.0, ends[-1], ds), ends]))
    starts = np.concatenate([[0.0], ends[:-1]])
    psi = sum(bend / R * np.clip(s - a, 0.0, length) for a, (length, bend) in zip(starts, pieces, strict=True))
    return s, np.column_stack([cumulative_trapezoid(f(psi), s, initial=0.0) for f in (np.cos, np.sin)])


TRACED_S, TRACED = traced()


def test_the_radius_at_ten_metres_per_second_is_that_of_the_issue():
    assert radius(10.0, 0.5, 9.81) == pytest.approx(20.39, abs=0.005)
    assert radius(20.0, 0.5, 9.81) == pytest.approx(4 * R, rel=1e-14)


def test_the_arc_angle_and_the_length_are_those_of_the_resolutions():
    assert math.degrees(SHAPE.theta) == pytest.approx(18.92, abs=0.005)
    assert SHAPE.theta == pytest.approx(THETA, rel=1e-12)
    assert SHAPE.length == pytest.approx(17.0, abs=0.01)


@given(r=st.floats(5, 200), l_d=st.floats(0, 30), share=st.floats(0.001, 0.999))
def test_the_angle_solves_the_equation_of_the_offset(r, l_d, share):
    w = share * (2 * r + l_d)  # the largest offset with arcs of at most a quarter of the circle
    shape = LaneChange(w=w, R=r, l_d=l_d)
    assert 2 * r * (1 - np.cos(shape.theta)) + l_d * np.sin(shape.theta) == pytest.approx(w, rel=1e-9, abs=1e-9)
    assert 0 <= shape.theta <= math.pi / 2 + 1e-9
    assert shape.length == pytest.approx(2 * r * np.sin(shape.theta) + l_d * np.cos(shape.theta), rel=1e-12)


def test_all_fifteen_waypoints_lie_where_the_construction_puts_them():
    run, drop = R * math.sin(THETA), R * (1 - math.cos(THETA))
    third = (120 - 62 - LENGTH) / 3
    expected = {
        0: (0, 0),
        1: (20, 0),
        3: (20 + run, drop),
        4: (20 + run, drop),
        5: (20 + LENGTH - run, 3.5 - drop),
        6: (20 + LENGTH - run, 3.5 - drop),
        7: (20 + LENGTH, 3.5),
        8: (62, 3.5),
        9: (62 + run, 3.5 - drop),
        10: (62 + LENGTH - run, drop),
        11: (62 + LENGTH, 0),
        12: (62 + LENGTH + third, 0),
        13: (62 + LENGTH + 2 * third, 0),
        14: (120, 0),
    }
    for i, point in expected.items():
        assert (PATH.waypoints.x[i], PATH.waypoints.y[i]) == pytest.approx(point, rel=1e-12, abs=1e-12), f"P{i}"


@pytest.mark.parametrize("corner", [CORNER, (25.0, 1.25), (22.0, 5.0), (10.0, 1.0)])
def test_p2_is_the_point_of_the_first_arc_nearest_to_the_obstacles_boundary(corner):
    waypoints = double_lane_change(SHAPE, x_0=0.0, x_1=20.0, x_8=62.0, x_14=120.0, y_lane=0.0, corner=corner).waypoints
    angles = np.linspace(0, THETA, 200_001)
    arc = np.column_stack([20 + R * np.sin(angles), R * (1 - np.cos(angles))])
    nearest = arc[np.argmin(np.hypot(*(arc - corner).T))]
    assert (waypoints.x[2], waypoints.y[2]) == pytest.approx(nearest, abs=1e-4)


@pytest.mark.parametrize("w", [3.5, -3.5, 1.0, 7.0])
def test_the_path_and_its_direction_are_continuous_at_every_joint(w):
    segments = path_of(LaneChange(w=w, R=R, l_d=4.0)).segments
    for before, after in pairwise(segments):
        assert before.point(before.length) == pytest.approx(after.point(0.0), abs=1e-12)
        assert before.psi + before.kappa * before.length == pytest.approx(after.psi, abs=1e-14)


def test_arcs_have_the_radius_and_lines_none():
    assert [round(s.kappa * R) for s in PATH.segments] == [0, 1, 0, -1, 0, -1, 0, 1, 0]
    assert [s.straight for s in PATH.segments] == [True, False] * 4 + [True]


def test_the_path_is_the_curve_that_its_curvature_draws():
    assert TRACED_S[-1] == pytest.approx(TOTAL, rel=1e-12)
    for s, point in zip(TRACED_S[::97], TRACED[::97], strict=True):
        assert PATH.point(s) == pytest.approx(point, abs=1e-6)


def test_the_direction_is_the_slope_of_the_curve_and_the_curvature_that_of_the_direction():
    starts = np.cumsum([0.0, *(segment.length for segment in PATH.segments)])
    for s in np.arange(0.05, TOTAL, 0.31):
        if np.abs(starts - s).min() < 2e-3:
            continue  # curvature jumps where pieces join
        psi, kappa = PATH.direction(s)
        (x_a, y_a), (x_b, y_b) = PATH.point(s - 1e-3), PATH.point(s + 1e-3)
        assert psi == pytest.approx(math.atan2(y_b - y_a, x_b - x_a), abs=1e-8)
        slope = (PATH.direction(s + 1e-3)[0] - PATH.direction(s - 1e-3)[0]) / 2e-3
        assert kappa == pytest.approx(slope, abs=1e-10)


def test_the_direction_beyond_both_ends_is_along_the_road():
    for s in (-5.0, 0.0, TOTAL, TOTAL + 50.0):
        assert PATH.direction(s) == pytest.approx((0.0, 0.0), abs=1e-14)


@given(s=st.floats(0.0, TOTAL))
def test_a_point_of_the_path_projects_on_itself(s):
    assert PATH.project(*PATH.point(s)) == pytest.approx(s, abs=1e-9)


@given(x=st.floats(-10, 130), y=st.floats(-6, 10))
def test_no_point_of_the_path_is_nearer_than_the_projection(x, y):
    x_s, y_s = PATH.point(PATH.project(x, y))
    found, brute = math.hypot(x_s - x, y_s - y), np.hypot(TRACED[:, 0] - x, TRACED[:, 1] - y).min()
    assert brute - 0.0026 <= found <= brute + 1e-6  # samples lie 5 mm apart


@given(kappa=st.sampled_from([1 / R, -1 / R]), psi=st.floats(-3, 3), s=st.floats(0, 6), off=st.floats(-15, 15))
def test_a_point_beside_an_arc_projects_on_its_foot(kappa, psi, s, off):
    arc = Segment(2.0, -1.0, psi, kappa, 6.0, straight=False)
    x, y = arc.point(s)
    heading = psi + kappa * s
    beside = (x - off * math.sin(heading), y + off * math.cos(heading))
    assert arc.project(*beside) == pytest.approx(s, abs=1e-9)


def test_before_the_start_and_behind_the_end_the_path_goes_straight_on():
    assert PATH.point(-7.0) == (-7.0, 0.0)
    assert PATH.point(TOTAL + 5.0) == pytest.approx((125.0, 0.0), abs=1e-12)
    assert PATH.project(-7.0, 1.0) == 0.0
    assert PATH.project(130.0, -1.0) == pytest.approx(TOTAL, rel=1e-14)


@given(s=st.floats(-10, 130), v=st.floats(1, 40), l_d=st.floats(0, 20))
@example(s=0.0, v=1.0, l_d=1e-9)  # a difference of angles is off by 2e-9 there
def test_no_offset_gives_the_straight_lane(s, v, l_d):
    flat = LaneChange(w=0.0, R=radius(v, 0.5, 9.81), l_d=l_d)
    assert flat.theta == pytest.approx(0.0, abs=1e-12)
    assert flat.length == pytest.approx(l_d, abs=1e-9)
    path = path_of(flat, x_8=62.0, y_lane=1.5)
    assert path.point(s) == pytest.approx((s, 1.5), abs=1e-9)
    assert path.waypoints.y == pytest.approx(np.full(15, 1.5), abs=1e-9)


@given(w=st.floats(0.1, 8), x=st.floats(-10, 130), y=st.floats(-6, 10))
def test_a_change_to_the_right_is_the_mirror_image_of_one_to_the_left(w, x, y):
    left = path_of(LaneChange(w=w, R=R, l_d=4.0))
    right = double_lane_change(
        LaneChange(w=-w, R=R, l_d=4.0), x_0=0.0, x_1=20.0, x_8=62.0, x_14=120.0, y_lane=0.0, corner=(46.85, -1.25)
    )
    assert right.waypoints.x == pytest.approx(left.waypoints.x, abs=1e-12)
    assert right.waypoints.y == pytest.approx(-left.waypoints.y, abs=1e-12)
    s = left.project(x, y)
    assert right.project(x, -y) == pytest.approx(s, abs=1e-9)
    assert right.point(s) == pytest.approx((left.point(s)[0], -left.point(s)[1]), abs=1e-12)
