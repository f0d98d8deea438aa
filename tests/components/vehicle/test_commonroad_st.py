"""The single-track model is the package's own: against its published point values, and against odeint."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import odeint
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st

from components.interfaces.buses import Actuation
from components.interfaces.record import pack, unpack
from components.interfaces.sockets import PlantInputs
from components.vehicle.commonroad import _slope
from components.vehicle.commonroad_st import CommonroadSt, StState

P = parameters_vehicle2()


def test_the_slope_is_the_packages_with_our_actuation():
    """The point of the package's own unit test: v_delta = 0.15 rad/s, a = 0.63 g."""
    x = [2.0233348142065677, 0.0041907137716636, 0.0197545248559617, 15.7216236334290116, 0.0025857914776859,
         0.0529001056654038, 0.0033012170610298]  # fmt: skip
    expected = [15.7213512030862397, 0.0925527979719355, 0.15, 5.3536773276413925, 0.0529001056654038,
                0.6435589397748606, 0.0313297971641291]  # fmt: skip
    T_delta, a = 0.05, 0.63 * 9.81
    u = np.array([x[2] + 0.15 * T_delta, a * P.m * P.R_w / 2])
    found = _slope(CommonroadSt.dynamics(), np.array(x), u, np.array([2.0, T_delta, *[0.0] * 6]))
    assert found == pytest.approx(expected, abs=1e-13)


def test_two_seconds_match_odeint(make):
    vehicle, T_delta = make("commonroad_st", T_delta=0.1), 0.1
    delta_f, T_r = 0.03, 60.0

    def slope(x, _):
        return vehicle_dynamics_st(list(x), [(delta_f - x[2]) / T_delta, 2 * T_r / (P.m * P.R_w)], P)

    expected = odeint(slope, pack(vehicle.start()), [0.0, 2.0], rtol=1e-11, atol=1e-12)[-1]
    x = vehicle.start()
    for _ in range(20):
        x = vehicle.step(x, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r)), 0.1)
    assert pack(x) == pytest.approx(expected, rel=1e-4, abs=1e-5)


def test_the_bus_shows_speed_and_slip_as_components(make):
    x = unpack(StState, np.array([1.0, 2.0, 0.1, 10.0, 0.3, 0.2, 0.1]))
    state = make("commonroad_st").shown(x)
    assert pack(state) == pytest.approx([1.0, 2.0, 0.3, 10 * np.cos(0.1), 10 * np.sin(0.1), 0.2], rel=1e-12)
