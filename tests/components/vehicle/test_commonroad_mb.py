"""The multi-body model is the package's own: against its published point values, and against odeint."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import odeint
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb

from components.interfaces.buses import Actuation
from components.interfaces.record import pack
from components.interfaces.sockets import PlantInputs
from components.vehicle.commonroad import _slope
from components.vehicle.commonroad_mb import CommonroadMb

P = parameters_vehicle2()
POINT = """10.8808433066274794 0.5371850187869442 0.0980442671005920 18.0711398687457745 0.1649995631003776
0.6158755000936103 -0.1198403612262477 -0.2762672756169581 0.0131909920269115 -0.0718483683742141 -0.3428324595054725
0.0103233373083297 -0.0399590564140291 -0.0246468320579360 -0.0551575051990853 0.5798277643297529 0.0172059354801703
0.0067890113155477 -0.0184269459410162 -0.0408207136116175 -1.0064484829203018 0.0166808347900582 -0.0049188492004049
53.6551710641082451 50.7045242506744316 56.7917911784219598 200.7079633169796296 -0.0939969123691911
-0.0881514621614376"""
SLOPE = """17.8820162482414098 2.6300428035858809 0.15 2.7009396644636450 0.6158755000936103 1.3132879472301846
-0.2762672756169581 -0.1360581472638375 -0.0718483683742141 0.4909514227532223 -2.6454134031927374 -0.0399590564140291
0.0486778649724968 -0.0551575051990853 0.0354501802049087 -1.1130397141873534 0.0067890113155477 -0.0886810139593130
-0.0408207136116175 0.0427680029698811 -4.3436374104751501 -0.0049188492004049 0.1142109377736169 10.0527321757776047
0.0436512393438736 -154.12795711273924 422.12780928288305 -0.2105876149500405 -0.2126005780977984"""


def test_the_slope_is_the_packages_with_our_actuation():
    """The point of the package's own unit test: v_delta = 0.15 rad/s, a = 0.63 g."""
    x, T_delta = np.array(POINT.split(), dtype=float), 0.05
    u = np.array([x[2] + 0.15 * T_delta, 0.63 * 9.81 * P.m * P.R_w / 2])
    found = _slope(CommonroadMb.dynamics(), x, u, np.array([2.0, T_delta, *[0.0] * 6]))
    assert found == pytest.approx(np.array(SLOPE.split(), dtype=float), abs=1e-7)


def test_two_seconds_match_odeint(make):
    vehicle, T_delta = make("commonroad_mb", T_delta=0.1), 0.1
    delta_f, T_r = 0.03, 60.0

    def slope(x, _):
        return vehicle_dynamics_mb(list(x), [(delta_f - x[2]) / T_delta, 2 * T_r / (P.m * P.R_w)], P)

    expected = odeint(slope, pack(vehicle.start()), [0.0, 2.0], rtol=1e-10, atol=1e-11, mxstep=10000)[-1]
    x = vehicle.start()
    for _ in range(20):
        x = vehicle.step(x, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r)), 0.1)
    assert pack(x) == pytest.approx(expected, rel=1e-4, abs=1e-5)


def test_in_a_left_turn_it_rolls_and_the_wheels_that_the_package_calls_left_run_faster(make):
    vehicle = make("commonroad_mb")
    x = vehicle.start()
    for _ in range(20):
        x = vehicle.step(x, PlantInputs(actuation=Actuation(delta_f=0.03, T_r=0.0)), 0.1)
    assert x.r > 0.05
    assert x.omega_fl > x.omega_fr
    assert abs(x.phi) > 1e-3
