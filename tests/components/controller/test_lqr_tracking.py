"""The regulator: its model against the plant's own derivative, its feedforward in a steady turn, its gain."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.controller.dubins import Path, Segment
from components.controller.tracking import Deviation, deviation, nearest
from components.interfaces.buses import Actuation, VehicleState, Waypoints
from components.interfaces.sockets import PlantInputs


@pytest.fixture(scope="module")
def lqr(make):
    return make("lqr")


def test_the_error_dynamics_are_the_plants_around_straight_running(make, lqr):
    """On a straight path e = y, psi_e = psi: differences of the plant's derivative give the same matrix."""
    plant, v, step = make("bicycle"), 10.0, 1e-6

    def accelerations(e_dot: float, psi: float, r: float, delta_f: float) -> np.ndarray:
        state = VehicleState(x=0.0, y=0.0, psi=psi, v_x=v, v_y=e_dot - v * psi, r=r)
        dx = plant.derivative(state, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=0.0)))
        return np.array([dx.v_y + v * r, dx.r])  # d/dt of e' = v_y + v psi, and of r

    rows, b = lqr.error_dynamics(v)
    columns = [(accelerations(*d) - accelerations(0, 0, 0, 0)) / step for d in step * np.eye(4)]
    assert np.array(rows)[[1, 3], 1:] == pytest.approx(np.column_stack(columns[:3]), rel=1e-6, abs=1e-6)
    assert b[[1, 3]] == pytest.approx(columns[3], rel=1e-6)
    assert np.array(rows)[[0, 2]].tolist() == [[0, 1, 0, 0], [0, 0, 0, 1]]


@pytest.mark.parametrize("kappa", [1 / 200, -1 / 200])
def test_the_feedforward_leaves_no_error_in_a_steady_turn(make, lqr, kappa):
    circle = Segment(0.0, 0.0, 0.0, kappa, 600.0, straight=False)
    nowhere = np.zeros(15)
    path = Path((circle,), Waypoints(x=nowhere, y=nowhere))
    plant, K, x = make("bicycle"), lqr.gain(), make("bicycle").start()
    errors = []
    for _ in range(200):
        target = nearest(path, x.x, x.y)
        at = deviation(target, x)
        errors.append(at.e)
        delta_f = lqr.steering(K, at, kappa, x.v_x)
        holding = plant.R_w / 2 * (2 * plant.forces(x, Actuation(delta_f=delta_f, T_r=0.0))[0] * math.sin(delta_f))
        slow = plant.m * plant.R_w / 2 * (-x.r * x.v_y)
        for _ in range(10):
            x = plant.step(x, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=holding + slow)), 0.01)
    assert x.v_x == pytest.approx(10.0, abs=0.05)
    assert max(map(abs, errors)) > 0.005  # the turn begins with a step of the curvature
    assert np.abs(errors[-20:]).max() < 5e-4


def test_the_steering_of_a_steady_turn_is_the_plants(make, lqr):
    """At a small curvature the plant rests in the state that the feedforward asks for."""
    kappa, v = 1e-4, 10.0
    psi_e, delta_f = lqr.steady_turn(kappa, v)
    state = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=v, v_y=-v * psi_e, r=kappa * v)
    dx = make("bicycle").derivative(state, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=0.0)))
    assert (dx.v_y, dx.r) == pytest.approx((0.0, 0.0), abs=1e-8)


def test_the_steering_is_feedforward_less_feedback(lqr):
    K = lqr.gain()
    psi_e, delta_f = lqr.steady_turn(0.02, 9.0)
    at = Deviation(e=0.1, e_dot=-0.2, psi_e=psi_e + 0.03, psi_e_dot=0.4)
    expected = delta_f - 0.1 * K.e + 0.2 * K.e_dot - 0.03 * K.psi_e - 0.4 * K.psi_e_dot
    assert lqr.steering(K, at, 0.02, 9.0) == pytest.approx(expected, rel=1e-12)


def test_a_larger_weight_of_the_steering_angle_means_a_smaller_gain(make):
    gains = [make("lqr", q_delta=q).gain().e for q in (0.1, 1.0, 10.0, 100.0)]
    assert gains == sorted(gains, reverse=True)
