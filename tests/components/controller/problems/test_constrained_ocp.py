"""The stages of `mpc_plus`: the plant's own equations, constraints that cost nothing inside, and limits by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controller.problems.constrained_ocp import (
    ConstrainedProblem,
    StageInput,
    StageTarget,
    SteeredVehicle,
    bounds,
    demands,
    derivative,
    loads,
    predict,
    residual,
)
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.record import pack, part
from components.interfaces.sockets import PlantInputs

BODY = ("x", "y", "psi", "v_x", "v_y", "r")
PATH_X, PATH_Y, SPEED, YAW, RATE, TORQUE, LEFT, RIGHT, FRONT, REAR, ANGLE = range(11)
states = st.builds(
    SteeredVehicle,
    x=st.floats(0, 100),
    y=st.floats(-2, 5),
    psi=st.floats(-0.6, 0.6),
    v_x=st.floats(7, 20),
    v_y=st.floats(-2, 2),
    r=st.floats(-1, 1),
    delta_f=st.floats(-0.5, 0.5),
)


@pytest.fixture(scope="module")
def problem(make) -> ConstrainedProblem:
    return part(ConstrainedProblem, make("mpc_plus"))


@pytest.fixture(scope="module")
def plant(make, problem):
    """The plant with saturating tyres, as the problem models it."""
    names = ("m", "I_z", "l_f", "l_r", "C_alpha_f", "C_alpha_r", "R_w", "mu", "g")
    return make("bicycle_saturated", **{name: getattr(problem, name) for name in names})


def straight(**changes) -> SteeredVehicle:
    return SteeredVehicle(**{**dict.fromkeys((*BODY, "delta_f"), 0.0), "v_x": 10.0, **changes})


def target(**changes) -> StageTarget:
    return StageTarget(**{"x_d": 0.0, "y_d": 0.0, "y_upper": 5.25, "y_lower": -1.75, "v_d": 10.0, **changes})


STILL = StageInput(delta_rate=0.0, T_r=0.0)


@given(x=states, T_r=st.floats(-0.8, 1.0), rate=st.floats(-1, 1))
def test_the_vehicle_moves_as_the_plant_with_saturating_tyres(problem, plant, x, T_r, rate):
    found = derivative(problem, x, StageInput(delta_rate=rate, T_r=T_r))
    body = VehicleState(**{name: getattr(x, name) for name in BODY})
    actuation = Actuation(delta_f=x.delta_f, T_r=problem.T_scale * T_r)
    expected = plant.derivative(body, PlantInputs(actuation=actuation))
    assert [getattr(found, name) for name in BODY] == pytest.approx(pack(expected).tolist(), rel=1e-10, abs=1e-10)
    assert found.delta_f == rate


def test_the_loads_are_the_static_ones_and_carry_the_weight(problem, plant):
    assert loads(problem) == pytest.approx(plant.loads(), rel=1e-12)
    assert 2 * sum(loads(problem)) == pytest.approx(problem.m * problem.g, rel=1e-12)


def test_the_demand_is_a_linear_tyre_s_share_of_the_friction_limit(problem):
    front, rear = demands(problem, straight(v_y=0.5, delta_f=0.1))
    F_zf, F_zr = loads(problem)
    assert front == pytest.approx(problem.C_alpha_f * (0.05 - 0.1) / (problem.mu * F_zf), rel=1e-12)
    assert rear == pytest.approx(problem.C_alpha_r * 0.05 / (problem.mu * F_zr), rel=1e-12)


@given(x=states, rate=st.floats(-1, 1))
def test_the_wheels_turn_at_the_beginning_of_a_step_and_are_then_held(problem, plant, x, rate):
    after = predict(problem, x, StageInput(delta_rate=rate, T_r=0.3))
    assert after.delta_f == pytest.approx(x.delta_f + problem.dt * rate, rel=1e-12, abs=1e-15)
    body = VehicleState(**{name: getattr(x, name) for name in BODY})
    held = PlantInputs(actuation=Actuation(delta_f=after.delta_f, T_r=0.3 * problem.T_scale))
    expected = plant.step(body, held, problem.dt)
    assert [getattr(after, name) for name in BODY] == pytest.approx(pack(expected).tolist(), rel=1e-9, abs=1e-9)


def test_on_its_path_at_its_speed_in_the_middle_of_the_corridor_nothing_costs(problem):
    assert residual(problem, target(), straight(), STILL) == [0.0] * 11


@pytest.mark.parametrize(
    ("state", "where", "stage", "inputs", "value"),
    [
        (straight(x=2.0), PATH_X, target(), STILL, lambda p: np.sqrt(p.a_1) * 2.0),
        (straight(y=0.5), PATH_Y, target(), STILL, lambda p: np.sqrt(p.a_1) * 0.5),
        (straight(v_x=9.0), SPEED, target(), STILL, lambda p: -np.sqrt(p.a_v)),
        (straight(), RATE, target(), StageInput(delta_rate=0.2, T_r=0.0), lambda p: np.sqrt(p.b_delta) * 0.2),
        (straight(), TORQUE, target(), StageInput(delta_rate=0.0, T_r=-0.5), lambda p: -np.sqrt(p.b_T) * 0.5),
    ],
)
def test_each_weight_by_hand(problem, state, where, stage, inputs, value):
    found = residual(problem, stage, state, inputs)
    assert found[where] == pytest.approx(value(problem), rel=1e-12)
    assert [r for i, r in enumerate(found) if i != where] == [0.0] * 10


def test_the_yaw_acceleration_is_weighed(problem):
    x = straight(delta_f=0.02)
    r_dot = derivative(problem, x, STILL).r
    assert residual(problem, target(), x, STILL)[YAW] == pytest.approx(np.sqrt(problem.b_3) * r_dot, rel=1e-12)


@pytest.mark.parametrize(("side", "where"), [(1.0, LEFT), (-1.0, RIGHT)])
def test_the_whole_body_stays_inside_the_corridor_or_the_slack_costs(problem, side, where):
    reach = problem.ego_width / 2 + problem.ego_length / 2 * 1e-3 + problem.l_margin
    stage = target(y_upper=2.0, y_lower=-2.0)
    inside, outside = (straight(y=side * (2.0 - reach + beyond)) for beyond in (-1e-6, 0.1))
    assert residual(problem, stage, inside, STILL)[where] == 0.0
    assert residual(problem, stage, outside, STILL)[where] == pytest.approx(0.1 * np.sqrt(problem.c_edge), rel=1e-9)
    turned = dataclasses.replace(inside, psi=0.3)
    assert residual(problem, stage, turned, STILL)[where] > 0, "a corner reaches further than the side"


def test_a_tyre_beyond_its_limit_costs_what_it_is_beyond(problem):
    F_zf, _ = loads(problem)
    angle = (problem.mu_limit + 0.2) * problem.mu * F_zf / problem.C_alpha_f
    found = residual(problem, target(), straight(delta_f=angle), STILL)
    assert found[FRONT] == pytest.approx(0.2 * np.sqrt(problem.c_mu), rel=1e-9)
    assert found[REAR] == 0.0


def test_an_angle_beyond_the_stop_costs(problem):
    found = residual(problem, target(), straight(delta_f=-problem.delta_max - 0.01), STILL)
    assert found[ANGLE] == pytest.approx(0.01 * np.sqrt(problem.c_edge), rel=1e-9)


def test_the_inputs_are_bounded_by_rate_and_torques(problem):
    low, high = bounds(problem)
    assert (low.delta_rate, high.delta_rate) == (-problem.delta_rate_max, problem.delta_rate_max)
    assert (low.T_r, high.T_r) == (-problem.T_bmax / problem.T_scale, problem.T_dmax / problem.T_scale)
