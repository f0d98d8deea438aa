"""The conversions of a mapping as equations (`conversions_in_words.py`), and the conventions of a bus in words."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from components.interfaces.conversion import Linear
from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable
from fmus.units.adaptation import Adaptation, Link, RateInput
from fmus.units.conventions import BoxEnd, ReferencePoint, RoadFrameVelocity, SpeedAndSlip
from orchestrator.exchange.conversions_in_words import conversions_in_words


def variable(name: str, unit: str) -> Variable:
    return Variable(name, Quantity(unit, "a signal"))


def words(**parts) -> list[str]:
    ours = SimpleNamespace(inputs=(variable("a.x", "rad"),), outputs=(variable("b.y", "m/s"),))
    theirs = SimpleNamespace(inputs=(variable("u", "deg"), variable("w", "deg/s")), outputs=(variable("v", "km/h"),))
    return conversions_in_words(SimpleNamespace(interface=ours, adaptation=Adaptation(**parts)), theirs)


@pytest.mark.parametrize(
    ("parts", "line"),
    [
        ({"outputs": (Link("b.y", (("v", 0),)),)}, "b.y [m/s] = v [km/h]"),
        ({"outputs": (Link("b.y", (("v", 0),), Linear(-1.0)),)}, "b.y [m/s] = -v [km/h]"),
        ({"outputs": (Link("b.y", (("v", 0),), Linear(0.25, -2.0)),)}, "b.y [m/s] = 0.25 * v [km/h] - 2"),
        ({"outputs": (Link("b.y", (("v", 0), ("v2", 0)), Linear(1.0, 3.0)),)}, "b.y [m/s] = v ... v2 [km/h] + 3"),
        ({"inputs": (Link("a.x", (("u", 0),), Linear(0.5), -30, 30),)}, "u [deg] = 2 * a.x [rad], kept in [-30, 30]"),
        ({"inputs": (Link("a.x", (("u", 0),), Linear(0.5), low=0.0),)}, "u [deg] = 2 * a.x [rad], at least 0"),
        (
            {"rates": (RateInput(Link("a.x", (("w", 0),)), None, 0.5),)},
            "w [deg/s] = rate towards a.x, at most 0.5 per s",
        ),
        ({"rates": (RateInput(Link("a.x", (("w", 0),)), None, math.inf),)}, "w [deg/s] = rate towards a.x"),
        ({"integrated": ("b.y",)}, "b.y = integral of what the FMU shows, from 0"),
        ({"constants": {"b.y": 0.0}}, "b.y [m/s] = 0.0"),
        ({"held": {"u": 5.0}}, "u [deg] = 5.0, held"),
        (
            {"conventions": {"b": (ReferencePoint(2.0),)}},
            "b: of a point 2 m ahead of the centre of gravity: x - 2 m cos(psi), y - 2 m sin(psi), v_y - 2 m r",
        ),
        (
            {"conventions": {"b": (BoxEnd(0.5),)}},
            "b: of the front bumper: x - 0.5 length cos(psi), y - 0.5 length sin(psi)",
        ),
        (
            {"conventions": {"b": (SpeedAndSlip(),)}},
            "b: speed v and slip angle beta: v_x = v cos(beta), v_y = v sin(beta)",
        ),
        (
            {"conventions": {"b": (RoadFrameVelocity(),)}},
            "b: velocity in the road frame, turned by -psi into the body frame",
        ),
    ],
)
def test_a_conversion_is_told_as_an_equation(parts, line):
    assert words(**parts) == [line]
