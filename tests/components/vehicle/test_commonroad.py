"""What the vehicles of commonroad-vehicle-models share: servo, drive force, and a stop that does not reverse."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from components.interfaces.record import pack
from components.interfaces.sockets import PlantInputs
from components.vehicle import commonroad
from components.vehicle.commonroad import installed
from fmus.lowering import lower
from tests.components.vehicle.paper_car import driven

NAMES = ["commonroad_st", "commonroad_mb"]
MASS, R_W = 1093.2952334674046, 0.344  # parameter set 2


def after(vehicle, seconds: float, u: PlantInputs, x=None):
    x = vehicle.start() if x is None else x
    for _ in range(round(seconds / 0.1)):
        x = vehicle.step(x, u, 0.1)
    return x


@pytest.mark.parametrize("name", NAMES)
def test_it_starts_as_the_parameters_say(make, name):
    vehicle = make(name, x_start=3.0, y_start=-1.0, psi_start=0.2, v_x_start=12.0, v_y_start=0.5, r_start=0.1)
    state = vehicle.shown(vehicle.start())
    assert pack(state) == pytest.approx([3.0, -1.0, 0.2, 12.0, 0.5, 0.1], rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_the_wheels_follow_the_angle_with_the_servos_time_constant(make, name):
    x = make(name).start()
    for _ in range(5):
        x = make(name).step(x, driven(0.005), 0.01)  # far below the limit of the rate
    assert x.delta == pytest.approx(0.005 * (1 - np.exp(-1)), rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_the_wheels_turn_no_faster_than_the_parameter_set_allows(make, name):
    x = after(make(name), 0.1, driven(0.3))
    assert x.delta == pytest.approx(0.04, rel=1e-6)  # 0.4 rad/s


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("T_r", [150.0, -100.0])
def test_the_torque_of_two_wheels_accelerates_the_mass(make, name, T_r):
    vehicle = make(name, v_x_start=15.0)
    x = after(vehicle, 2.0, driven(T_r=T_r))
    gained = vehicle.shown(x).v_x - 15.0
    mass = MASS + (4 * 1.7 / R_W**2 if name == "commonroad_mb" else 0)  # the inertia of its four wheels, and some slip
    assert gained == pytest.approx(2 * 2 * T_r / (mass * R_W), rel=1e-6 if name == "commonroad_st" else 0.003)


@pytest.mark.parametrize("name", NAMES)
def test_braking_ends_in_a_standstill_and_not_in_reverse(make, name):
    vehicle = make(name, v_x_start=3.0)
    speeds = []
    x = vehicle.start()
    for _ in range(60):
        x = vehicle.step(x, driven(0.05, -160.0), 0.1)
        speeds.append(vehicle.shown(x).v_x)
    assert min(speeds) == 0.0
    assert speeds[-10:] == [0.0] * 10
    before, later = vehicle.shown(x), vehicle.shown(vehicle.step(x, driven(0.05, -160.0), 0.1))
    assert pack(before).tolist() == pack(later).tolist()
    assert np.isfinite(pack(x)).all()
    assert pack(vehicle.output(x, driven(0.05, -160.0)).motion).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("name", NAMES)
def test_the_stop_is_where_the_speed_is_zero_and_not_a_step_later(make, name):
    vehicle = make(name, v_x_start=2.0)
    a = 2 * 160.0 / (MASS * R_W)
    x = after(vehicle, 5.0, driven(T_r=-160.0))
    wheels = 4 * 1.7 / R_W**2 / MASS if name == "commonroad_mb" else 0
    assert x.x == pytest.approx(2.0**2 / 2 / a * (1 + wheels), rel=1e-5 if name == "commonroad_st" else 0.005)


@pytest.mark.parametrize("name", NAMES)
def test_a_vehicle_that_stands_turns_its_wheels_and_drives_off_again(make, name):
    vehicle = make(name, v_x_start=0.0)
    standing = after(vehicle, 1.0, driven(0.1, 0.0))
    assert vehicle.shown(standing).v_x == 0.0
    assert standing.delta == pytest.approx(0.1, rel=1e-6)
    moving = after(vehicle, 2.0, driven(0.0, 100.0), standing)
    assert 0.3 < vehicle.shown(moving).v_x < 3.0


@pytest.mark.parametrize("name", NAMES)
def test_motion_is_the_slope_of_the_speeds_in_turning_axes(make, name):
    vehicle, u, h = make(name), driven(0.04, 80.0), 1e-4
    x = after(vehicle, 0.8, u)
    ahead = vehicle.shown(vehicle.step(x, u, h))
    now, motion = vehicle.shown(x), vehicle.output(x, u).motion
    a_x = (ahead.v_x - now.v_x) / h - now.r * now.v_y
    a_y = (ahead.v_y - now.v_y) / h + now.r * now.v_x
    assert (motion.a_x, motion.a_y) == pytest.approx((a_x, a_y), rel=2e-3, abs=2e-3)
    assert motion.r_dot == pytest.approx((ahead.r - now.r) / h, rel=2e-3, abs=2e-3)


@pytest.mark.parametrize("vehicle", [1, 2, 3])
@pytest.mark.parametrize("name", NAMES)
def test_all_parameter_sets_of_the_package_drive(make, name, vehicle):
    x = after(make(name, vehicle=vehicle), 1.0, driven(0.02, 50.0))
    assert make(name).shown(x).y > 0.1


@pytest.mark.parametrize("name", NAMES)
def test_what_is_not_finite_stays_so(make, name):
    vehicle = make(name)
    x = vehicle.step(vehicle.start(), driven(float("nan")), 0.1)
    assert np.isnan(pack(x)).all()


@pytest.mark.parametrize("name", NAMES)
def test_as_a_node_of_the_equations_it_says_the_same_as_with_plain_numbers(make, name):
    vehicle, u = make(name), driven(0.03, 60.0)
    found, x = lower(type(vehicle)), vehicle.start()
    for _ in range(5):
        column = found.step(pack(x), pack(u), pack(vehicle), 0.1)
        x = vehicle.step(x, u, 0.1)
        assert np.asarray(column).ravel().tolist() == pack(x).tolist()
        shown = found.output(pack(x), pack(u), pack(vehicle))
        assert np.asarray(shown).ravel().tolist() == pack(vehicle.output(x, u)).tolist()


@pytest.mark.parametrize("name", NAMES)
def test_actuation_reaches_motion_at_once_and_state_never(make, name):
    reach = lower(type(make(name))).feedthrough
    assert not reach[:6].any()
    assert reach[6:].all()


def test_a_step_that_does_not_come_to_its_end_is_given_up(make, monkeypatch):
    monkeypatch.setattr(commonroad, "MOST_CALLS", 10)
    vehicle = make("commonroad_st")
    assert np.isnan(pack(vehicle.step(vehicle.start(), driven(0.1), 0.1))).all()


def test_the_package_is_there_or_not(monkeypatch):
    assert installed()
    monkeypatch.setattr(commonroad, "find_spec", lambda _: None)
    assert not installed()


def test_the_catalogue_does_not_import_the_package():
    """It is slow to import, and an extra."""
    code = "import sys, components; sys.exit('vehiclemodels' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
