"""What `mpc_plus` makes of a sample; whole runs, against what it was made for, are in `closed_loop/test_plus.py`."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controller.constrained_mpc import PREDICTION_STEPS
from components.interfaces.buses import SolverStatus
from components.interfaces.record import pack
from components.interfaces.sockets import ControllerInputs


@pytest.fixture(scope="module")
def plus(make):
    return make("mpc_plus")


@given(v=st.floats(0, 20), v_d=st.floats(0, 20), t=st.floats(0, 3))
def test_the_desired_point_speeds_up_or_slows_down_as_the_vehicle_can(plus, v, v_d, t):
    times = np.linspace(0.0, t, 2001)
    speeds = v + np.clip(v_d - v, -plus.a_follow * times, plus.a_follow * times)
    assert plus.progress(v, v_d, t) == pytest.approx(np.trapezoid(speeds, times), rel=1e-5, abs=1e-5)


def test_an_obstacle_that_is_followed_does_not_narrow_the_corridor(plus, obstacles):
    seen = obstacles({"x": 30.0, "y": 0.0}, {"x": 50.0, "y": 3.5})
    assert plus.beside(seen, 0.0).valid[:3].tolist() == [0.0, 1.0, 0.0]
    assert plus.beside(seen, 3.5).valid[:3].tolist() == [1.0, 0.0, 0.0]
    assert plus.beside(seen, 0.0).length[:2].tolist() == [4.6 + plus.ego_length] * 2
    assert plus.beside(seen, 0.0).width.tolist() == seen.width.tolist()


def test_the_path_s_arcs_leave_some_friction_for_corrections(make, plus):
    whole = make("mpc_plus", mu_share=1.0).shape().R
    assert pytest.approx(whole / plus.mu_share, rel=1e-12) == plus.shape().R


def test_on_its_lane_at_its_speed_it_asks_for_almost_nothing(plus, vehicle, obstacles):
    x, y = plus.sample(plus.start(), ControllerInputs(ego=vehicle(), obstacles=obstacles()))
    assert abs(y.actuation.delta_f) < 1e-6
    assert abs(y.actuation.T_r) < 1.0
    assert y.solver.status == SolverStatus.converged
    assert y.plan.x.shape == y.plan.x_d.shape == (PREDICTION_STEPS,)
    assert x.delta_f == y.actuation.delta_f


def test_a_vehicle_left_of_its_path_steers_right_at_a_bounded_rate(plus, vehicle, obstacles):
    x, y = plus.sample(plus.start(), ControllerInputs(ego=vehicle(y=0.5), obstacles=obstacles()))
    assert -plus.dt * plus.delta_rate_max <= y.actuation.delta_f < -0.001
    assert np.isfinite(pack(x)).all()


def test_an_ego_that_is_no_number_is_met_by_the_previous_plan(plus, vehicle, obstacles):
    lost = ControllerInputs(ego=vehicle(v_y=float("nan")), obstacles=obstacles())
    x, y = plus.sample(plus.start(), lost)
    assert y.solver.status == SolverStatus.fallback
    assert (y.actuation.delta_f, y.actuation.T_r) == (0.0, 0.0)
    assert np.isfinite(pack(x)).all()
    assert np.isfinite(pack(y.plan)).all()
