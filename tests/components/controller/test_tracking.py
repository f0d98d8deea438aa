"""Errors from a path by hand and along motions, the fixed path, and the speed controller with its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controller.planner import no_manoeuvre
from components.controller.tracking import Target, bounded, deviation, nearest
from components.interfaces.buses import VehicleState
from components.interfaces.record import pack
from components.interfaces.sockets import ControllerInputs

STATIC = ({"x": 49.5, "y": 0.0}, {"x": 92.5, "y": 3.5}, {"x": 110.5, "y": 3.5})


@pytest.fixture(scope="module")
def stanley(make):
    return make("stanley")


def test_the_errors_of_one_state_by_hand(vehicle):
    target = Target(x=10.0, y=2.0, psi=math.pi / 6, kappa=0.05)
    # 0.4 m to the left of the target and 1 m further along, 0.1 rad to the left of its direction
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    ego = vehicle(x=10 + c - 0.4 * s, y=2 + s + 0.4 * c, psi=math.pi / 6 + 0.1, v_x=9.0, v_y=0.5, r=0.7)
    found = deviation(target, ego)
    assert found.e == pytest.approx(0.4, rel=1e-12)
    assert found.e_dot == pytest.approx(9 * math.sin(0.1) + 0.5 * math.cos(0.1), rel=1e-12)
    assert found.psi_e == pytest.approx(0.1, rel=1e-12)
    assert found.psi_e_dot == pytest.approx(0.7 - 0.45, rel=1e-12)


@given(psi=st.floats(-3, 3), heading=st.floats(-0.9, 0.9), v_x=st.floats(2, 20), v_y=st.floats(-3, 3))
def test_the_rate_of_the_lateral_error_is_its_slope_in_time(psi, heading, v_x, v_y):
    target = Target(x=1.0, y=2.0, psi=psi, kappa=0.0)

    def at(t: float) -> VehicleState:
        along = complex(v_x, v_y) * np.exp(1j * (psi + heading)) * t
        return VehicleState(x=1 + along.real, y=2.5 + along.imag, psi=psi + heading, v_x=v_x, v_y=v_y, r=0.0)

    slope = (deviation(target, at(1e-3)).e - deviation(target, at(-1e-3)).e) / 2e-3
    assert deviation(target, at(0.0)).e_dot == pytest.approx(slope, abs=1e-8)


def test_a_full_turn_more_is_no_heading_error(vehicle):
    target = Target(x=0.0, y=0.0, psi=0.1, kappa=0.0)
    assert deviation(target, vehicle(psi=0.3 + 2 * math.pi)).psi_e == pytest.approx(0.2, abs=1e-12)


def test_the_nearest_point_has_the_direction_and_curvature_of_the_path_there(stanley, vehicle, obstacles):
    u = ControllerInputs(ego=vehicle(), obstacles=obstacles(*STATIC))
    path = stanley.path(stanley.manoeuvre(no_manoeuvre(), u), u.ego)
    target = nearest(path, 24.0, 0.6)
    R = 100 / (0.5 * 9.81)
    assert target.kappa == pytest.approx(1 / R, rel=1e-12)
    assert math.hypot(target.x - 20.0, target.y - R) == pytest.approx(R, rel=1e-9)
    assert target.psi == pytest.approx(math.atan2(target.x - 20.0, R - target.y), rel=1e-9)


def test_the_path_is_that_of_mpc_and_stays_whatever_the_traffic_does(make, stanley, vehicle, obstacles):
    u = ControllerInputs(ego=vehicle(), obstacles=obstacles(*STATIC))
    first = stanley.sample(stanley.start(), u)
    mpc = make("mpc")
    expected = mpc.path(mpc.manoeuvre(no_manoeuvre(), u), u.ego).waypoints
    assert pack(first[1].path).tolist() == pack(expected).tolist()
    later = ControllerInputs(ego=vehicle(x=15.0), obstacles=obstacles({"x": 30.0, "y": 0.0, "v": 4.0}))
    assert pack(stanley.sample(first[0], later)[1].path).tolist() == pack(expected).tolist()


def test_without_a_reason_to_change_lanes_the_path_stays_open(stanley, vehicle, obstacles):
    x, y = stanley.sample(stanley.start(), ControllerInputs(ego=vehicle(), obstacles=obstacles()))
    assert y.path.y.tolist() == [0.0] * 15
    u = ControllerInputs(ego=vehicle(x=5.0), obstacles=obstacles(*STATIC))
    assert stanley.sample(x, u)[1].path.y[7] == pytest.approx(3.5, abs=1e-9)


def test_the_torque_is_proportional_and_integral(stanley, vehicle):
    actuation, integral = stanley.actuation(0.1, 10.0, 20.0, vehicle(v_x=9.9))
    assert actuation.T_r == pytest.approx(600 * 0.1 + 20, rel=1e-12)
    assert integral == pytest.approx(20 + 150 * 0.1 * 0.1, rel=1e-12)
    assert actuation.delta_f == 0.1


def test_at_a_bound_the_integral_rests_until_the_error_turns(stanley, vehicle):
    actuation, integral = stanley.actuation(0.0, 10.0, 20.0, vehicle(v_x=5.0))
    assert (actuation.T_r, integral) == (200.0, 20.0)
    actuation, integral = stanley.actuation(0.0, 10.0, -20.0, vehicle(v_x=15.0))
    assert (actuation.T_r, integral) == (-160.0, -20.0)
    actuation, integral = stanley.actuation(0.0, 10.0, 500.0, vehicle(v_x=10.1))  # too much, and too fast
    assert (actuation.T_r, integral) == (200.0, pytest.approx(498.5))


def test_the_speed_is_reached_without_a_lasting_error_or_much_overshoot(make, stanley, vehicle):
    plant, x, integral, speeds = make("bicycle"), vehicle(v_x=8.0), 0.0, []
    for _ in range(200):
        actuation, integral = stanley.actuation(0.0, 10.0, integral, x)
        force = 2 * (actuation.T_r - 40.0) / plant.R_w  # 40 N.m go on a hill
        x = vehicle(v_x=x.v_x + 0.1 * force / plant.m)
        speeds.append(x.v_x)
    assert max(speeds) < 10.3
    assert speeds[-1] == pytest.approx(10.0, abs=1e-3)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_no_number_becomes_no_actuation(value):
    assert bounded(value, -1.0, 2.0) == 0.0


@pytest.mark.parametrize("name", ["lqr", "stanley", "pure_pursuit"])
@pytest.mark.parametrize("lost", ["x", "y", "psi", "v_x", "v_y", "r"])
def test_a_lost_sample_is_met_without_actuation_and_forgotten(make, vehicle, obstacles, name, lost):
    block, seen = make(name), obstacles(*STATIC)
    x, _ = block.sample(block.start(), ControllerInputs(ego=vehicle(), obstacles=seen))
    x, y = block.sample(x, ControllerInputs(ego=vehicle(**{lost: float("nan")}), obstacles=seen))
    assert np.isfinite(pack(x)).all()
    assert np.isfinite(pack(y.actuation)).all()
    after = block.sample(x, ControllerInputs(ego=vehicle(x=1.0), obstacles=seen))[1]
    assert np.isfinite(pack(after)).all()


@pytest.mark.parametrize("name", ["lqr", "stanley", "pure_pursuit"])
@given(x=st.floats(-20, 150), y=st.floats(-20, 20), psi=st.floats(-7, 7), v_x=st.floats(-5, 40), r=st.floats(-9, 9))
def test_the_actuation_stays_inside_its_bounds_whatever_the_state(make, vehicle, obstacles, name, x, y, psi, v_x, r):
    block = make(name)
    u = ControllerInputs(ego=vehicle(x=x, y=y, psi=psi, v_x=v_x, r=r), obstacles=obstacles(*STATIC))
    found = block.sample(block.start(), u)[1].actuation
    assert abs(found.delta_f) <= block.delta_max
    assert -block.T_bmax <= found.T_r <= block.T_dmax


@pytest.mark.parametrize("name", ["lqr", "stanley", "pure_pursuit"])
@given(y=st.floats(-1, 1), psi=st.floats(-0.3, 0.3), v_y=st.floats(-1, 1), r=st.floats(-0.5, 0.5), x=st.floats(0, 100))
def test_left_and_right_are_alike(make, vehicle, obstacles, name, x, y, psi, v_y, r):
    left, right = make(name), make(name, y_adjacent=-3.5)
    others = [[{**o, "y": side * o["y"]} for o in STATIC] for side in (1.0, -1.0)]
    here = vehicle(x=x, y=y, psi=psi, v_y=v_y, r=r)
    there = vehicle(x=x, y=-y, psi=-psi, v_y=-v_y, r=-r)
    a = left.sample(left.start(), ControllerInputs(ego=here, obstacles=obstacles(*others[0])))[1].actuation
    b = right.sample(right.start(), ControllerInputs(ego=there, obstacles=obstacles(*others[1])))[1].actuation
    assert b.delta_f == pytest.approx(-a.delta_f, abs=1e-9)
    assert b.T_r == pytest.approx(a.T_r, abs=1e-9)
