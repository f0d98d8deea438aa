"""The Stanley law at points worked out by hand."""

from __future__ import annotations

import math

import pytest

from components.interfaces.sockets import ControllerInputs


@pytest.mark.parametrize(("y", "psi", "v_x"), [(0.5, 0.0, 10.0), (-0.3, 0.1, 8.0), (0.0, -0.2, 12.0), (1.0, 0.05, 5.0)])
def test_on_a_straight_path_it_is_the_law_at_the_front_axle(make, vehicle, obstacles, y, psi, v_x):
    block = make("stanley", k=2.5)
    u = ControllerInputs(ego=vehicle(x=3.0, y=y, psi=psi, v_x=v_x), obstacles=obstacles())
    front = y + 1.2 * math.sin(psi)
    expected = -psi - math.atan(2.5 * front / v_x)
    assert block.sample(block.start(), u)[1].actuation.delta_f == pytest.approx(expected, rel=1e-9)


def test_a_steering_beyond_the_bound_is_clipped(make, vehicle, obstacles):
    block = make("stanley", k=5.0)
    u = ControllerInputs(ego=vehicle(y=4.0, psi=0.5), obstacles=obstacles())
    assert block.sample(block.start(), u)[1].actuation.delta_f == -block.delta_max


def test_with_the_front_axle_on_an_arc_only_the_heading_counts(make, vehicle, obstacles):
    """On the first arc of the lane change, 15 degrees round its centre, 0.1 rad left of the tangent."""
    block, R, a = make("stanley"), 100 / (0.5 * 9.81), math.radians(15)
    psi = a + 0.1
    x, y = 20 + R * math.sin(a) - 1.2 * math.cos(psi), R * (1 - math.cos(a)) - 1.2 * math.sin(psi)
    first = block.sample(block.start(), ControllerInputs(ego=vehicle(), obstacles=obstacles({"x": 49.5, "y": 0.0})))[0]
    u = ControllerInputs(ego=vehicle(x=x, y=y, psi=psi), obstacles=obstacles({"x": 49.5, "y": 0.0}))
    assert block.sample(first, u)[1].actuation.delta_f == pytest.approx(-0.1, abs=1e-6)
