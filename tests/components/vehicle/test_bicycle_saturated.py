"""The saturating tyre: as the linear one where slip is small, and never beyond the friction limit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.record import pack
from tests.components.vehicle.paper_car import I_Z, L_F, L_R, MU, R_W, C, G, M, driven, states, steering

LIMIT_F, LIMIT_R = (MU * M * G * lever / (L_F + L_R) / 2 for lever in (L_R, L_F))  # lever rule, one tyre

moving = states(v_y=8, r=4)


@pytest.fixture(scope="module")
def saturated(make):
    return make("bicycle_saturated")


@pytest.fixture(scope="module")
def linear(make):
    return make("bicycle")


def test_one_point_of_the_tyre_by_hand(saturated, vehicle):
    # slip 0.2 at the front, 12000 * 0.2 = 2400 N over a limit of 2289 N: tanh(1.048493) = 7.141593 / 9.141593
    front, rear = saturated.forces(vehicle(v_y=2.0), Actuation(delta_f=0.0, T_r=0.0))
    assert front == pytest.approx(-2289 * 7.141593 / 9.141593, rel=1e-6)
    assert rear == pytest.approx(-2616 * np.tanh(2400 / 2616), rel=1e-12)


def test_the_slope_at_the_origin_is_that_of_the_linear_tyre(saturated, linear, vehicle):
    state, u = vehicle(v_y=1e-4, r=1e-4), Actuation(delta_f=2e-5, T_r=0.0)
    assert saturated.forces(state, u) == pytest.approx(linear.forces(state, u), rel=1e-8)


@given(state=moving, delta_f=steering)
def test_no_lateral_force_passes_the_friction_limit_or_the_linear_tyre(saturated, linear, state, delta_f):
    u = Actuation(delta_f=delta_f, T_r=0.0)
    found, straight = saturated.forces(state, u), linear.forces(state, u)
    for force, limit, proportional in zip(found, (LIMIT_F, LIMIT_R), straight, strict=True):
        assert abs(force) <= limit * (1 + 1e-12)
        assert abs(force) <= abs(proportional) * (1 + 1e-12)
        assert force * proportional >= 0
    tyre = saturated.output(state, driven(delta_f)).tyre
    assert max(tyre.mu_f, tyre.mu_r) <= 1 + 1e-12


def test_the_driving_force_counts_towards_the_rear_share(saturated, vehicle):
    tyre = saturated.output(vehicle(v_y=9.0), driven(T_r=200.0)).tyre
    assert tyre.mu_r == pytest.approx(np.hypot(tyre.F_cr, 200 / 0.3) / LIMIT_R, rel=1e-12)
    assert tyre.mu_r > 1 > tyre.mu_f


@given(state=moving, delta_f=steering, T_r=st.floats(-160, 200))
def test_it_turns_right_as_it_turns_left(saturated, state, delta_f, T_r):
    turned = VehicleState(x=state.x, y=-state.y, psi=-state.psi, v_x=state.v_x, v_y=-state.v_y, r=-state.r)
    slope, other = (pack(saturated.derivative(s, driven(d, T_r))) for s, d in ((state, delta_f), (turned, -delta_f)))
    assert other.tolist() == (slope * [1, -1, -1, 1, -1, -1]).tolist()


def sliding(_: float, s: np.ndarray, delta_f: float, T_r: float) -> list[float]:
    """The same vehicle, written once more: axle forces, two tyres each."""
    _, _, psi, v_x, v_y, r = s
    front = -2 * LIMIT_F * np.tanh(C / LIMIT_F * ((v_y + L_F * r) / v_x - delta_f))
    rear = -2 * LIMIT_R * np.tanh(C / LIMIT_R * (v_y - L_R * r) / v_x)
    return [
        v_x * np.cos(psi) - v_y * np.sin(psi),
        v_x * np.sin(psi) + v_y * np.cos(psi),
        r,
        v_y * r + (2 * T_r / R_W - front * np.sin(delta_f)) / M,
        -v_x * r + (front * np.cos(delta_f) + rear) / M,
        (L_F * front - L_R * rear) / I_Z,
    ]


def test_a_hard_turn_matches_a_precise_integration(saturated):
    x = saturated.start()
    column = pack(x)
    for tick in range(30):
        delta_f, T_r = 0.25 * np.sin(0.3 * tick), 150.0 * np.cos(0.2 * tick)
        for _ in range(10):
            x = saturated.step(x, driven(delta_f, T_r), 0.01)
        column = solve_ivp(sliding, (0.0, 0.1), column, method="DOP853", rtol=1e-12, atol=1e-12, args=(delta_f, T_r)).y[
            :, -1
        ]
    assert np.abs(pack(x) - column).max() < 1e-5
    assert saturated.output(x, driven()).tyre.mu_r > 0.5  # it did slide
