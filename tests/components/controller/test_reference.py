"""The path of a sample, and the references of the prediction steps on it and in the corridor."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controller.corridor import Road, corridor
from components.controller.dubins import radius
from components.controller.planner import no_manoeuvre
from components.interfaces.record import pack
from components.interfaces.sockets import ControllerInputs

STATIC = ({"x": 49.5, "y": 0.0}, {"x": 92.5, "y": 3.5}, {"x": 110.5, "y": 3.5})


@pytest.fixture(scope="module")
def guidance(make):
    """A controller with a path and a prediction of three steps."""
    return make("mpc")


@pytest.fixture(scope="module")
def seen(vehicle, obstacles):
    """What the controller sees of the static scenario."""
    return lambda **ego: ControllerInputs(ego=vehicle(**ego), obstacles=obstacles(*STATIC))


def test_a_lane_change_reaches_the_adjacent_lane_on_arcs_of_the_friction_limit(guidance):
    shape = guidance.shape()
    assert shape.R == radius(guidance.v_ref, guidance.mu, guidance.g) == pytest.approx(100 / (0.5 * 9.81))
    assert (shape.w, shape.l_d) == (guidance.y_adjacent - guidance.y_lane, guidance.l_d)


def test_without_a_manoeuvre_the_path_is_the_lane_and_reaches_beyond_the_ego(guidance, vehicle):
    for x in (0.0, 300.0):
        path = guidance.path(no_manoeuvre(), vehicle(x=x))
        assert path.waypoints.y.tolist() == [guidance.y_lane] * 15
        assert path.waypoints.x[14] >= x + guidance.l_end


def test_a_planned_path_goes_out_and_back_where_the_manoeuvre_says(guidance, seen):
    u = seen()
    manoeuvre = guidance.manoeuvre(no_manoeuvre(), u)
    path = guidance.path(manoeuvre, u.ego).waypoints
    assert (path.x[1], path.x[8]) == (manoeuvre.x_1, manoeuvre.x_8)
    assert path.y[[0, 1, 11, 12, 13, 14]].tolist() == [guidance.y_lane] * 6
    assert path.y[[7, 8]].tolist() == [guidance.y_adjacent] * 2
    assert path.x[14] == pytest.approx(manoeuvre.x_8 + guidance.shape().length + guidance.l_end, rel=1e-12)


@given(x=st.floats(0, 120), y=st.floats(-1, 4), v_x=st.floats(2, 10))
def test_the_desired_points_are_equal_distances_apart_along_the_path_from_the_ego_on(guidance, seen, x, y, v_x):
    u = seen(x=x, y=y, v_x=v_x)
    found = guidance.reference(guidance.manoeuvre(no_manoeuvre(), seen()), u)
    path = guidance.path(found.manoeuvre, u.ego)
    s, gone = path.project(x, y), found.manoeuvre.v_d * guidance.dt
    points = np.array([path.point(s + gone * (i + 1)) for i in range(guidance.N_p)])
    assert found.horizon.x_d == pytest.approx(points[:, 0], rel=1e-12, abs=1e-12)
    assert found.horizon.y_d == pytest.approx(points[:, 1], rel=1e-12, abs=1e-12)
    assert pack(found.path).tolist() == pack(path.waypoints).tolist()
    steps = np.hypot(np.diff(found.horizon.x_d), np.diff(found.horizon.y_d))
    assert steps.max() <= gone * (1 + 1e-9), "a chord is no longer than its arc"


def test_the_boundaries_are_the_corridor_s_at_the_desired_points_and_their_times(guidance, vehicle, obstacles):
    moving = obstacles({"x": 40.0, "y": 0.0, "v": 6.0}, {"x": 55.0, "y": 3.5, "v": 9.0})
    found = guidance.reference(no_manoeuvre(), ControllerInputs(ego=vehicle(x=20.0), obstacles=moving)).horizon
    road = Road(y_left=guidance.y_left, y_right=guidance.y_right, l_gap=guidance.l_gap, l_ramp=guidance.l_ramp)
    free = [corridor(road, moving, x_d, guidance.dt * (i + 1)) for i, x_d in enumerate(found.x_d)]
    assert list(zip(found.y_upper, found.y_lower, strict=True)) == free


def test_an_obstacle_beside_the_path_narrows_the_corridor(guidance, seen):
    found = guidance.reference(guidance.manoeuvre(no_manoeuvre(), seen()), seen(x=44.0, y=3.0)).horizon
    assert found.y_lower.max() == pytest.approx(0.9 + 0.35)
    assert found.y_upper.tolist() == [guidance.y_left] * 3
    assert math.isclose(found.y_d.max(), 3.5, rel_tol=1e-9)


@pytest.mark.parametrize(
    ("y_third", "third", "places"),
    [
        (1e6, 0.0, {0.0: 1.8, 3.5: 1.8}),  # two lanes: the middle of the road
        (-3.5, 0.0, {0.0: 1.75, 3.5: 1.75}),
        (-3.5, 1.0, {0.0: -1.75, -3.5: -1.75}),
        (7.0, 0.0, {0.0: 1.75, 3.5: 1.75}),
        (7.0, 1.0, {0.0: 1.75, 3.0: 1.75, 4.0: 5.25, 7.0: 5.25}),
    ],
)
def test_obstacles_are_parted_by_the_line_that_the_change_crosses(make, y_third, third, places):
    block = make("mpc", y_third=y_third, y_left=5.35)
    manoeuvre = dataclasses.replace(no_manoeuvre(), third=third)
    assert {y: block.parting(manoeuvre, y) for y in places} == pytest.approx(places)


@pytest.mark.parametrize(("y_third", "w"), [(-3.5, -3.5), (7.0, 7.0), (1e6, 3.5)])
def test_a_change_to_the_third_lane_reaches_it_on_the_same_arcs(make, vehicle, y_third, w):
    block = make("mpc", y_third=y_third)
    shape, one = block.shape(1.0), block.shape()
    assert (shape.w, shape.R) == (w, one.R)
    assert shape.theta == pytest.approx(one.theta)  # no harder to follow, but longer
    assert shape.length == pytest.approx(one.length + (abs(w) - 3.5) / math.tan(one.theta))
    manoeuvre = dataclasses.replace(no_manoeuvre(), planned=1.0, x_1=20.0, x_8=80.0, third=1.0)
    path = block.path(manoeuvre, vehicle()).waypoints
    assert path.y[[7, 8]].tolist() == [w, w]
    assert path.x[7] == pytest.approx(20.0 + block.shape(1.0).length)


@given(v=st.floats(0, 30), v_d=st.floats(0, 30), t=st.floats(0.01, 2))
def test_the_desired_point_slows_down_no_faster_than_the_vehicle_can(guidance, v, v_d, t):
    braking = v * t - guidance.a_follow * t * (t + guidance.dt) / 2
    assert guidance.progress(v, v_d, t) == pytest.approx(max(v_d * t, braking), rel=1e-12)
    lower = guidance.progress(v, 0.0, t)  # however low the speed behind somebody is all of a sudden
    assert guidance.progress(v, v, t) - lower <= guidance.a_follow * t * (t + guidance.dt) / 2 * (1 + 1e-9) + 1e-9
