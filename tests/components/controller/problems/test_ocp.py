"""The optimal control problem (5)-(9) against a literal transcription and against sums done by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from components.controller.problems.ocp import (
    CLOSEST,
    Horizon,
    OptimalControlProblem,
    PredictedVehicle,
    Weights,
    predict,
)
from components.interfaces.buses import VehicleState

TABLE_1 = {"m": 2000.0, "I_z": 1300.0, "l_f": 1.2, "l_r": 1.05, "C_alpha_f": 12000.0, "C_alpha_r": 12000.0, "R_w": 0.3}
N_P = 3


def problem(horizon: Horizon, start: VehicleState, **changes: Any) -> OptimalControlProblem:
    values = {
        "vehicle": PredictedVehicle(**TABLE_1),
        "weights": Weights(a_1=1.0, b_1=0.1, b_2=0.1, b_3=0.01),
        "dt": 0.1,
        "delta_max": np.pi / 4,
        "T_dmax": 200.0,
        "T_bmax": 160.0,
        "delta_scale": 1.0,
        "T_scale": 200.0,
        **changes,
    }
    return OptimalControlProblem(horizon=horizon, start=start, **values)


def horizon_of(x_d: Any, y_d: Any, y_upper: Any, y_lower: Any) -> Horizon:
    return Horizon(**{n: np.asarray(v, dtype=float) for n, v in locals().items()})


def transcribed(start: VehicleState, delta_f: np.ndarray, T_r: np.ndarray, dt: float) -> dict[str, list[float]]:
    """(6)-(9) line by line, indices as printed, with RESOLUTIONS 1 (factor 2), 2 (I_z), 10 and 11."""
    m, I_z, l_f, l_r, C_f, C_r, R_w = TABLE_1.values()
    h: dict[str, list[float]] = {n: [getattr(start, n)] for n in ("x", "y", "psi", "v_x", "v_y", "r")}
    h["r_dot"] = []
    for i in range(1, len(delta_f) + 1):
        v_x, v_y, r, psi, x, y = (h[n][i - 1] for n in ("v_x", "v_y", "r", "psi", "x", "y"))
        F_cf = C_f * delta_f[i - 1] - C_f * v_y / v_x - C_f * l_f * r / v_x
        F_cr = C_r * l_r * r / v_x - C_r * v_y / v_x
        h["v_x"].append(v_x + dt * v_y * r - dt * 2 * F_cf * np.sin(delta_f[i - 1]) / m + dt * 2 * T_r[i - 1] / R_w / m)
        h["v_y"].append(v_y - dt * v_x * r + dt * 2 * F_cf * np.cos(delta_f[i - 1]) / m + dt * 2 * F_cr / m)
        h["r_dot"].append(2 * l_f * F_cf / I_z - 2 * l_r * F_cr / I_z)
        h["r"].append(r + dt * h["r_dot"][-1])
        h["psi"].append(psi + dt * r)
        speed = complex(h["v_x"][i], h["v_y"][i]) * np.exp(1j * h["psi"][i])
        h["x"].append(x + dt * speed.real)
        h["y"].append(y + dt * speed.imag)
    return h


states = st.builds(
    VehicleState,
    x=st.floats(0, 100),
    y=st.floats(-1, 4),
    psi=st.floats(-0.6, 0.6),
    v_x=st.floats(8, 20),
    v_y=st.floats(-2, 2),
    r=st.floats(-1, 1),
)
decisions = arrays(float, 2 * N_P, elements=st.floats(-0.78, 0.78))


def test_one_prediction_step_by_hand(vehicle):
    after = predict(PredictedVehicle(**TABLE_1), vehicle(v_y=0.5, r=0.2), delta_f=0.1, T_r=100.0, dt=0.1)
    # forces 312 N and -348 N as in the plant's point value
    v_x = 10 + 0.1 * (0.1 - 0.001 * (312 * 0.09983341664682815 - 1000 / 3))
    v_y = 0.5 + 0.1 * (-2.0 + 0.001 * (312 * 0.9950041652780258 - 348))
    assert (after.v_x, after.v_y) == pytest.approx((v_x, v_y), rel=1e-12)
    assert after.r == pytest.approx(0.2 + 0.1 * 2 * 739.8 / 1300, rel=1e-12)
    assert after.psi == pytest.approx(0.02, rel=1e-12)
    sine, cosine = 0.01999866669333308, 0.9998000066665778
    assert after.x == pytest.approx(0.1 * (v_x * cosine - v_y * sine), rel=1e-12)
    assert after.y == pytest.approx(0.1 * (v_x * sine + v_y * cosine), rel=1e-12)


@given(start=states, z=decisions, dt=st.sampled_from([0.05, 0.1]))
def test_the_prediction_is_the_papers_line_by_line(start, z, dt):
    flat = np.zeros(N_P)
    found = problem(horizon_of(flat, flat, flat, flat), start, dt=dt).prediction(z)
    expected = transcribed(start, z[:N_P], 200 * z[N_P:], dt)
    for name in ("x", "y", "psi", "v_x", "v_y", "r"):
        assert [getattr(s, name) for s in found] == pytest.approx(expected[name][1:], rel=1e-9, abs=1e-9), name


@given(start=states, z=decisions, dt=st.sampled_from([0.05, 0.1]), free=st.floats(0.5, 9))
def test_the_cost_is_the_papers_sum(start, z, dt, free):
    p = transcribed(start, z[:N_P], 200 * z[N_P:], dt)
    X_d, Y_d = start.x + 10 * dt * np.arange(1, N_P + 1), np.array([0.1, 0.3, 0.7])
    Y_u, Y_l = Y_d + free, Y_d - 2 * free
    J = 0.0
    for i in range(N_P):
        x, y = p["x"][i + 1], p["y"][i + 1]
        J += 1.0 * ((x - X_d[i]) ** 2 + (y - Y_d[i]) ** 2)
        for b, edge in ((0.1, Y_u[i]), (0.2, Y_l[i])):
            J += b * (1 / max(np.hypot(x - X_d[i], y - edge) ** 2, 1e-3)) ** 2
        J += 0.01 * abs(p["r_dot"][i]) ** 2
    weights = Weights(a_1=1.0, b_1=0.1, b_2=0.2, b_3=0.01)
    found = problem(horizon_of(X_d, Y_d, Y_u, Y_l), start, dt=dt, weights=weights).cost(z)
    assert found == pytest.approx(J, rel=1e-6)


@given(
    v_x=st.floats(0, 20),
    delta_f=st.floats(-0.5, 0.5),
    T_r=st.floats(-20, 20),
    v_y=st.floats(-0.5, 0.5),
    r=st.floats(-0.5, 0.5),
    dt=st.sampled_from([0.05, 0.1, 0.2]),
)
def test_a_prediction_holds_from_rest_on(vehicle, v_x, delta_f, T_r, v_y, r, dt):
    car = PredictedVehicle(**TABLE_1)
    now = vehicle(v_x=v_x, v_y=v_y, r=r)
    for _ in range(60):
        now = predict(car, now, delta_f, T_r, dt)
        assert abs(now.r) < 8
        assert abs(now.v_y) < 25


@given(v_x=st.floats(0.01, 1.0), delta_f=st.floats(-0.2, 0.2))
def test_a_slow_prediction_turns_as_the_kinematic_vehicle(vehicle, v_x, delta_f):
    car = PredictedVehicle(**TABLE_1)
    now = vehicle(v_x=v_x)
    for _ in range(60):
        now = replace(predict(car, now, delta_f, 0.0, 0.1), v_x=v_x)
    assert now.r == pytest.approx(v_x * delta_f / (car.l_f + car.l_r), rel=0.06, abs=1e-12)


def test_the_cost_of_straight_running_by_hand(vehicle):
    # predicted at 1, 2, 3 m; desired 1.5, 2, 2 m and 0, 0.5, 0 m across: squares along 0.25, 0, 1
    horizon = horizon_of([1.5, 2.0, 2.0], [0.0, 0.5, 0.0], [5.0, 5.0, 5.0], [-2.0, -2.0, -2.0])
    weights = Weights(a_1=3.0, b_1=100.0, b_2=7.0, b_3=1.0)
    path = 3 * (0.25 + 0.25 + 1.0)
    upper = 100 * (1 / 25.25**2 + 1 / 25**2 + 1 / 26**2)
    lower = 7 * (1 / 4.25**2 + 1 / 4**2 + 1 / 5**2)
    found = problem(horizon, vehicle(), weights=weights).cost(np.zeros(6))
    assert found == pytest.approx(path + upper + lower, rel=1e-12)


def test_the_yaw_term_is_the_square_of_the_yaw_acceleration(vehicle):
    # one step, steering 0.1 rad: r_dot = 2 * 1.2 * 12000 * 0.1 / 1300
    weights = Weights(a_1=0.0, b_1=0.0, b_2=0.0, b_3=2.0)
    found = problem(horizon_of([1.0], [0.0], [5.0], [-2.0]), vehicle(), weights=weights).cost(np.array([0.1, 0.0]))
    assert found == pytest.approx(2 * (2880 / 1300) ** 2, rel=1e-12)


@pytest.mark.parametrize("distance", [0.0, 0.01, 0.03])
def test_a_boundary_nearer_than_the_clip_costs_no_more(vehicle, distance):
    assert CLOSEST == 1e-3
    weights = Weights(a_1=0.0, b_1=0.0, b_2=1.0, b_3=0.0)
    horizon = horizon_of([1.0], [0.0], [5.0], [-distance])
    assert problem(horizon, vehicle(), weights=weights).cost(np.zeros(2)) == pytest.approx(1e6, rel=1e-9)


def test_a_boundary_just_outside_the_clip_counts_in_full(vehicle):
    weights = Weights(a_1=0.0, b_1=0.0, b_2=1.0, b_3=0.0)
    horizon = horizon_of([1.0], [0.0], [5.0], [-0.1])
    assert problem(horizon, vehicle(), weights=weights).cost(np.zeros(2)) == pytest.approx(1e4, rel=1e-9)


def test_bounds_and_controls_are_in_the_units_of_the_optimisation(vehicle):
    scaled = problem(
        horizon_of([0, 0], [0, 0], [0, 0], [0, 0]), vehicle(), delta_max=0.8, delta_scale=0.4, T_scale=80.0
    )
    lower, upper = scaled.bounds()
    assert lower.tolist() == [-2.0, -2.0, -2.0, -2.0]
    assert upper.tolist() == [2.0, 2.0, 2.5, 2.5]
    assert scaled.controls(upper) == [(0.8, 200.0), (0.8, 200.0)]
    assert scaled.controls(lower) == [(-0.8, -160.0), (-0.8, -160.0)]
    assert scaled.controls(np.array([1.0, 2.0, 0.5, -1.0])) == [(0.4, 40.0), (0.8, -80.0)]
