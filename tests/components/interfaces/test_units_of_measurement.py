"""What the units of measurement of other makers mean."""

from __future__ import annotations

import math

import pytest

from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT, BaseUnit, base_unit


@pytest.mark.parametrize("unit", UNITS_OF_MEASUREMENT)
def test_our_own_units_are_read_alike_by_pint(unit):
    """Twice the exponents of the unit times itself: a string that is not in our list and so goes through pint."""
    found = base_unit(f"({unit}).({unit})" if unit != "1" else "m/m")
    assert found is not None
    exponents = UNITS_OF_MEASUREMENT[unit].base.exponents
    assert {b: n for b, n in found.exponents.items() if n} == {b: 2 * n for b, n in exponents.items()}
    assert (found.factor, found.offset) == (1.0, 0.0)


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("N.m/deg", BaseUnit({"kg": 1, "m": 2, "s": -2, "rad": -1}, 180 / math.pi)),
        ("1/min", BaseUnit({"s": -1}, 1 / 60)),
        ("kg.m2/s2", BaseUnit({"kg": 1, "m": 2, "s": -2})),
        ("m/s^2", BaseUnit({"m": 1, "s": -2})),
        ("J/(kg.K)", BaseUnit({"m": 2, "s": -2, "K": -1})),
        ("m/(s2)", BaseUnit({"m": 1, "s": -2})),
        ("kmh", BaseUnit({"m": 1, "s": -1}, 1 / 3.6)),
        ("mm", BaseUnit({"m": 1}, 1e-3)),
        ("Nm", BaseUnit({"kg": 1, "m": 2, "s": -2})),
    ],
)
def test_common_spellings(unit, expected):
    found = base_unit(unit)
    assert found is not None
    assert found.exponents == expected.exponents
    assert (found.factor, found.offset) == (pytest.approx(expected.factor, rel=1e-12), 0.0)


@pytest.mark.parametrize(
    "unit", ["furlong", "", "-", "m/", "import os", "__class__", "1e3", "m**0.5", "2", "J/kg.K", "J/kg*K"]
)
def test_what_nobody_knows_is_no_unit(unit):
    assert base_unit(unit) is None


@pytest.mark.parametrize(
    "unit",
    [
        *("t9999999", "t-9999999", "t^9999999", "t**9999999", "m.t999", "(t)9999999", "(t 2)9999999", "9999999999.t"),
        *("m" * 101, "(km99)" * 10, "((((((((((m", "t\u0669\u0669\u0669"),
    ],
)
def test_units_with_which_one_could_compute_for_ever_are_none(unit):
    assert base_unit(unit) is None


def test_exponents_of_two_digits_are_read():
    found = base_unit("m99")
    assert found is not None
    assert found.exponents["m"] == 99
