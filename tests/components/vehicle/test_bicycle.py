"""The bicycle against equations (1)-(3) worked out by hand, and against what is known of such a vehicle.

This also shows `single_track.py`: the bicycle adds no more than the forces of linear tyres.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from components.interfaces.buses import VehicleState
from components.interfaces.record import pack, unpack
from tests.components.vehicle.paper_car import I_Z, L_F, L_R, MU, R_W, C, G, M, driven, states, steering

moving = states(v_y=3, r=2)
torque = st.floats(-160, 200)


@pytest.fixture(scope="module")
def bicycle(make):
    return make("bicycle")


def newton(state: VehicleState, delta_f: float, T_r: float) -> tuple[complex, float]:
    """Inertial acceleration in body axes (a complex number) and yaw acceleration, from a sum of forces."""
    axle_speed = {end: complex(state.v_x, state.v_y + state.r * lever) for end, lever in (("f", L_F), ("r", -L_R))}
    slope = {end: v.imag / v.real for end, v in axle_speed.items()}  # the paper's small-angle slip
    front = 2 * C * (delta_f - slope["f"]) * 1j * np.exp(1j * delta_f)  # both front tyres, across the turned wheel
    rear = 2 * complex(T_r / R_W, -C * slope["r"])
    moment = L_F * 2 * C * (delta_f - slope["f"]) + L_R * 2 * C * slope["r"]  # as printed: no cos(delta_f)
    return (front + rear) / M, moment / I_Z


def test_the_default_parameters_are_those_of_the_paper(bicycle):
    found = [getattr(bicycle, n) for n in ("m", "I_z", "l_f", "l_r", "C_alpha_f", "C_alpha_r", "R_w", "mu", "g")]
    assert found == [M, I_Z, L_F, L_R, C, C, R_W, MU, G]
    assert pack(bicycle.start()).tolist() == [0.0, 0.0, 0.0, 10.0, 0.0, 0.0]


def test_one_point_of_the_equations_by_hand(bicycle, vehicle):
    state, u = vehicle(v_y=0.5, r=0.2), driven(0.1, 100.0)
    # (3): (0.5 + 1.2 * 0.2) / 10 - 0.1 and (0.5 - 1.05 * 0.2) / 10
    assert bicycle.slip(state, u.actuation) == pytest.approx((-0.026, 0.029), rel=1e-12)
    # (2): 12000 N/rad
    assert bicycle.forces(state, u.actuation) == pytest.approx((312.0, -348.0), rel=1e-12)
    dx = bicycle.derivative(state, u)
    sine, cosine = 0.09983341664682815, 0.9950041652780258
    assert dx.v_x == pytest.approx(0.1 - 0.001 * (312 * sine - 1000 / 3), rel=1e-12)
    assert dx.v_y == pytest.approx(-2.0 + 0.001 * (312 * cosine - 348), rel=1e-12)
    assert dx.r == pytest.approx(2 * (374.4 + 365.4) / 1300, rel=1e-12)
    assert (dx.x, dx.y, dx.psi) == (10.0, 0.5, 0.2)


@given(state=moving, delta_f=steering, T_r=torque)
def test_the_derivative_is_newtons_law_in_turning_axes(bicycle, state, delta_f, T_r):
    dx = bicycle.derivative(state, driven(delta_f, T_r))
    force, moment = newton(state, delta_f, T_r)
    speed = complex(state.v_x, state.v_y)
    assert complex(dx.v_x, dx.v_y) == pytest.approx(force - 1j * state.r * speed, rel=1e-12, abs=1e-12)
    assert dx.r == pytest.approx(moment, rel=1e-12, abs=1e-11)
    assert complex(dx.x, dx.y) == pytest.approx(speed * np.exp(1j * state.psi), rel=1e-12, abs=1e-12)
    assert dx.psi == state.r


@given(state=moving, delta_f=steering, T_r=torque)
def test_motion_shows_the_inertial_acceleration_in_body_axes(bicycle, state, delta_f, T_r):
    motion = bicycle.output(state, driven(delta_f, T_r)).motion
    force, moment = newton(state, delta_f, T_r)
    assert complex(motion.a_x, motion.a_y) == pytest.approx(force, rel=1e-12, abs=1e-11)
    assert motion.r_dot == pytest.approx(moment, rel=1e-12, abs=1e-11)


@given(state=moving, delta_f=steering, T_r=torque)
def test_friction_shares_are_axle_force_over_friction_times_static_axle_load(bicycle, state, delta_f, T_r):
    tyre = bicycle.output(state, driven(delta_f, T_r)).tyre
    load_r = M * G * L_F / (L_F + L_R)  # lever rule about the front axle
    load_f = M * G - load_r
    slip_f = np.divide(state.v_y + L_F * state.r, state.v_x) - delta_f
    slip_r = np.divide(state.v_y - L_R * state.r, state.v_x)
    assert (tyre.alpha_f, tyre.alpha_r) == pytest.approx((slip_f, slip_r), rel=1e-12, abs=1e-15)
    assert (tyre.F_cf, tyre.F_cr) == pytest.approx((-C * slip_f, -C * slip_r), rel=1e-12, abs=1e-11)
    assert tyre.mu_f == pytest.approx(abs(2 * C * slip_f) / (MU * load_f), rel=1e-12, abs=1e-14)
    assert tyre.mu_r == pytest.approx(np.hypot(2 * C * slip_r, 2 * T_r / R_W) / (MU * load_r), rel=1e-12, abs=1e-14)


def test_the_torque_alone_uses_its_share_of_the_rear_friction(bicycle, vehicle):
    tyre = bicycle.output(vehicle(), driven(T_r=200.0)).tyre
    assert tyre.mu_f == 0.0
    assert tyre.mu_r == pytest.approx(2 * 200 / 0.3 / (0.5 * 2000 * 9.81 * 1.2 / 2.25), rel=1e-12)


@given(state=moving)
def test_the_state_is_shown_as_it_is(bicycle, state):
    assert bicycle.output(state, driven(0.3, 50.0)).state is state


@given(psi=st.floats(-3, 3), v=st.floats(1, 50), h=st.floats(1e-3, 0.01))
def test_coasting_straight_keeps_speed_and_heading(bicycle, psi, v, h):
    state = VehicleState(x=1.0, y=2.0, psi=psi, v_x=v, v_y=0.0, r=0.0)
    after = bicycle.step(state, driven(), h)
    assert (after.v_x, after.v_y, after.r, after.psi) == (v, 0.0, 0.0, psi)
    assert complex(after.x - 1.0, after.y - 2.0) == pytest.approx(v * h * np.exp(1j * psi), rel=1e-12, abs=1e-12)


@given(T_r=torque, v=st.floats(5, 30))
def test_driving_straight_turns_the_torque_into_speed_distance_and_energy(bicycle, T_r, v):
    x = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=v, v_y=0.0, r=0.0)
    for _ in range(100):
        x = bicycle.step(x, driven(T_r=T_r), 0.01)
    a = 2 * T_r / (M * R_W)
    assert x.v_x == pytest.approx(v + a, rel=1e-12)
    assert x.x == pytest.approx(v + a / 2, rel=1e-12)
    work, energy = 2 * T_r / R_W * x.x, M / 2 * (x.v_x**2 - v**2)
    assert energy == pytest.approx(work, rel=1e-9, abs=1e-6)


def test_the_torque_limits_give_the_accelerations_of_the_resolutions(bicycle, vehicle):
    assert bicycle.derivative(vehicle(), driven(T_r=200.0)).v_x == pytest.approx(0.667, abs=5e-4)
    assert bicycle.derivative(vehicle(), driven(T_r=-160.0)).v_x == pytest.approx(-0.533, abs=5e-4)


@pytest.mark.parametrize("v", [5.0, 10.0, 15.0, 19.0])
def test_steady_cornering_has_the_yaw_gain_of_the_linear_single_track_model(bicycle, v):
    delta_f, L, C_axle = 1e-5, L_F + L_R, 2 * C

    def rest(unknown: np.ndarray) -> list[float]:
        dx = bicycle.derivative(
            VehicleState(x=0.0, y=0.0, psi=0.0, v_x=v, v_y=unknown[0], r=unknown[1]), driven(delta_f)
        )
        return [dx.v_y, dx.r]

    _, r = fsolve(rest, [0.0, 0.0], xtol=1e-10)
    understeer = M * (L_R * C_axle - L_F * C_axle) / (L * C_axle * C_axle)
    assert r / delta_f == pytest.approx(v / (L + understeer * v**2), rel=1e-8)


def test_the_car_oversteers_and_has_the_poles_and_the_critical_speed_of_the_resolutions(bicycle):
    def lateral(v: float) -> np.ndarray:
        def slope(v_y: float, r: float) -> np.ndarray:
            dx = bicycle.derivative(VehicleState(x=0.0, y=0.0, psi=0.0, v_x=v, v_y=v_y, r=r), driven())
            return np.array([dx.v_y, dx.r])

        return np.column_stack([slope(1.0, 0.0), slope(0.0, 1.0)])  # linear in v_y and r

    assert np.sort(np.linalg.eigvals(lateral(10.0))) == pytest.approx([-5.6, -1.5], abs=0.05)
    assert np.linalg.eigvals(lateral(20.0)).max() < 0 < np.linalg.eigvals(lateral(20.2)).max()


def steered(t: float) -> tuple[float, float]:
    return 0.05 * np.sin(2 * t), 100 * np.cos(t)


def test_the_integration_is_of_fourth_order(bicycle):
    u = driven(0.08, 150.0)
    start = VehicleState(x=0.0, y=0.0, psi=0.1, v_x=10.0, v_y=0.2, r=0.1)

    def slope(_: float, column: np.ndarray) -> np.ndarray:
        return pack(bicycle.derivative(unpack(VehicleState, column), u))

    truth = solve_ivp(slope, (0.0, 1.0), pack(start), method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    errors = []
    for n in (40, 80, 160):
        x = start
        for _ in range(n):
            x = bicycle.step(x, u, 1.0 / n)
        errors.append(np.abs(pack(x) - truth).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([4.0, 4.0], abs=0.25)


def test_five_seconds_of_a_steering_profile_match_a_precise_integration(bicycle):
    def force(t: float, column: np.ndarray) -> np.ndarray:
        state = unpack(VehicleState, column)
        held = np.floor(t / 0.1 + 1e-9) * 0.1
        a, r_dot = newton(state, *steered(held))
        speed = complex(state.v_x, state.v_y)
        turning, road = a - 1j * state.r * speed, speed * np.exp(1j * state.psi)
        return np.array([road.real, road.imag, state.r, turning.real, turning.imag, r_dot])

    column = pack(bicycle.start())
    x = bicycle.start()
    for tick in range(50):
        t = tick * 0.1
        for _ in range(10):
            x = bicycle.step(x, driven(*steered(t)), 0.01)
        frozen = lambda _, c, t=t: force(t, c)  # noqa: E731 - the input held over this tick
        column = solve_ivp(frozen, (0.0, 0.1), column, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert np.abs(pack(x) - column).max() < 1e-6


@given(v_x=st.floats(0, 1), delta_f=st.floats(-0.2, 0.2))
def test_a_slow_vehicle_turns_as_the_kinematic_one_and_one_at_rest_stays(bicycle, vehicle, v_x, delta_f):
    state, held = vehicle(v_x=v_x), driven(delta_f, 0.0)
    for _ in range(200):
        state = bicycle.step(state, held, 0.01)
    assert state.r == pytest.approx(state.v_x * delta_f / (L_F + L_R), rel=0.06, abs=1e-12)
    assert state.v_y == pytest.approx(L_R * state.r, rel=0.06, abs=0.01 * v_x + 1e-12)
    if v_x == 0:
        assert pack(state).tolist() == pack(vehicle(v_x=0.0)).tolist()
