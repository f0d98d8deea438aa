"""Pure pursuit at points worked out by hand, and the circle it promises."""

from __future__ import annotations

import math

import pytest

from components.interfaces.sockets import ControllerInputs

L = 2.25


@pytest.mark.parametrize("l_ahead", [6.0, 12.0])
@pytest.mark.parametrize(("y", "psi"), [(0.5, 0.0), (-0.4, 0.15), (0.0, -0.1)])
@pytest.mark.parametrize("l_back", [0.0, 1.05])
def test_on_a_straight_path_it_is_the_textbooks_angle(make, vehicle, obstacles, l_ahead, y, psi, l_back):
    block = make("pure_pursuit", l_ahead=l_ahead, l_back=l_back)
    u = ControllerInputs(ego=vehicle(x=30.0, y=y, psi=psi), obstacles=obstacles())
    x = block.sample(block.start(), ControllerInputs(ego=vehicle(), obstacles=obstacles()))[0]
    across = y - l_back * math.sin(psi)
    distance, eta = math.hypot(l_ahead, across), math.atan2(-across, l_ahead) - psi
    expected = math.atan(2 * L * math.sin(eta) / distance)
    assert block.sample(x, u)[1].actuation.delta_f == pytest.approx(expected, rel=1e-9)


def test_on_the_arc_it_asks_for_the_arcs_own_curvature(make, vehicle, obstacles):
    """Both the led point and the pursued one lie on the first arc of the lane change, tangent to it."""
    block, R, a = make("pure_pursuit", l_ahead=3.0), 100 / (0.5 * 9.81), math.radians(6)
    seen = obstacles({"x": 49.5, "y": 0.0})
    first = block.sample(block.start(), ControllerInputs(ego=vehicle(), obstacles=seen))[0]
    ego = vehicle(x=20 + R * math.sin(a), y=R * (1 - math.cos(a)), psi=a)
    found = block.sample(first, ControllerInputs(ego=ego, obstacles=seen))[1].actuation.delta_f
    assert found == pytest.approx(math.atan(L / R), rel=1e-6)
