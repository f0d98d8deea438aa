"""The roles of variables: one table says all there is to say of each."""

from __future__ import annotations

import pytest

from components.interfaces.conversion import unit_conversion
from components.interfaces.quantity import Quantity
from components.interfaces.sockets import SOCKETS
from orchestrator.mapping.roles import ROLE_NUMBERS, ROLES, roles_of

SIGNALS = {v.name.partition(".")[2]: v.quantity for socket in SOCKETS.values() for v in socket.signals()}
NUMBERS = {"ratio": 16.0, "R_w": 0.3, "m": 2000.0}


@pytest.mark.parametrize("name", ROLES)
def test_a_role_stands_for_a_signal_and_takes_numbers_that_are_described(name):
    role = ROLES[name]
    assert role.signal in SIGNALS
    assert set(role.numbers) <= set(ROLE_NUMBERS)
    assert f'"{name}"' in role.hint
    assert name in roles_of(role.signal)


@pytest.mark.parametrize("name", ROLES)
def test_the_scale_needs_the_required_numbers_only(name):
    role = ROLES[name]
    required = {n: NUMBERS[n] for n in role.numbers if ROLE_NUMBERS[n].required}
    assert role.scale(required) > 0


@pytest.mark.parametrize("name", ROLES)
def test_a_role_is_another_quantity_than_its_signal_or_another_scale(name):
    role = ROLES[name]
    same = unit_conversion(Quantity(role.unit, ""), Quantity(SIGNALS[role.signal].unit, "")) is not None
    assert not same or role.scale(NUMBERS) != 1


def test_the_torque_of_one_wheel_of_two():
    scales = {name: role.scale(NUMBERS) for name, role in roles_of("T_r").items()}
    assert scales == {
        "axle_torque": 2.0,
        "wheel_force": pytest.approx(1 / 0.3),
        "force": pytest.approx(2 / 0.3),
        "acceleration": pytest.approx(1 / 300),
    }


def test_most_signals_have_no_other_roles():
    assert roles_of("v_x") == {}
