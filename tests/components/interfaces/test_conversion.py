"""Values of one quantity as values of another."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.conversion import IDENTITY, Linear, Lookup, type_fits, unit_conversion
from components.interfaces.items import Enumeration
from components.interfaces.quantity import DTYPES, Quantity, Type
from components.interfaces.units_of_measurement import BaseUnit

numbers = st.floats(-1e6, 1e6)
factors = st.floats(1e-3, 1e3) | st.floats(-1e3, -1e-3)


def of(unit, kind=Type.FLOAT64, **more):
    return Quantity(unit, "a quantity", kind, **more)


@pytest.mark.parametrize(
    ("found", "wanted", "value", "expected"),
    [
        ("km/h", "m/s", 36.0, 10.0),
        ("m/s", "km/h", 10.0, 36.0),
        ("deg", "rad", 180.0, np.pi),
        ("deg/s", "rad/s", 90.0, np.pi / 2),
        ("rpm", "rad/s", 60.0, 2 * np.pi),
        ("kN", "N", 2.0, 2000.0),
        ("Nm", "N.m", 3.0, 3.0),
        ("degC", "K", 20.0, 293.15),
        ("K", "degC", 293.15, 20.0),
        ("%", "1", 55.0, 0.55),
        ("g_n", "m/s2", 1.0, 9.80665),
        ("m", "m", 1.5, 1.5),
        ("", "m", 1.5, 1.5),
        ("m", "", 1.5, 1.5),
    ],
)
def test_units_of_one_dimension_are_converted(found, wanted, value, expected):
    conversion = unit_conversion(of(found), of(wanted))
    assert conversion is not None
    assert conversion(value) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("found", "wanted"), [("kg", "m/s"), ("rad", "1"), ("Hz", "rad/s"), ("furlong", "m"), ("1", "N.m")]
)
def test_units_of_two_dimensions_and_units_nobody_knows_are_not(found, wanted):
    assert unit_conversion(of(found), of(wanted)) is None


def test_unknown_units_fit_when_they_are_spelled_alike():
    assert unit_conversion(of("furlong"), of("furlong")) == IDENTITY


def test_a_unit_that_is_none_of_its_base_unit_converts_to_no_other():
    nothing = of("o", base=BaseUnit({"m": 1}, factor=0.0))
    assert unit_conversion(of("m"), nothing) is None
    assert unit_conversion(nothing, of("m")) is None


def test_a_file_says_what_its_own_unit_means():
    furlong = of("furlong", base=BaseUnit({"m": 1}, factor=201.168))
    assert unit_conversion(furlong, of("m")) == Linear(201.168)
    strange = of("m", base=BaseUnit({"m": 1}, factor=0.001))  # a file whose `m` is a millimetre
    assert unit_conversion(strange, of("m")) == Linear(0.001)


@given(a=factors, b=numbers, c=factors, d=numbers, x=numbers)
def test_linear_conversions_compose_and_invert(a, b, c, d, x):
    first, then = Linear(a, b), Linear(c, d)
    scale = 1 + abs(c) * (abs(a * x) + abs(b)) + abs(d)
    assert then.after(first)(x) == pytest.approx(then(first(x)), abs=1e-9 * scale)
    assert first.inverse(first(x)) == pytest.approx(x, abs=1e-9 * (1 + abs(x) + abs(b / a)))


def test_a_lookup_changes_what_it_lists():
    assert Lookup({1: 10, 2: 20})(np.array([1, 2, 3], dtype=np.int32)).tolist() == [10, 20, 3]
    assert Lookup({True: False, False: True})(np.array([True, False])).tolist() == [False, True]


@pytest.mark.parametrize("found", [t for t in Type if t.is_integer or t.is_float])
@pytest.mark.parametrize("wanted", [t for t in Type if t.is_integer or t.is_float])
def test_numbers_fit_where_every_value_survives(found, wanted):
    """Independent truth: the extreme values of the one type, written into the other and read back."""
    if found.is_float:
        assert type_fits(of("", found), of("", wanted)) is wanted.is_float
        return
    info = np.iinfo(DTYPES[found])
    extremes = [info.min, info.max, info.max - 1]
    survives = all(_stored(value, DTYPES[wanted]) for value in extremes)
    assert type_fits(of("", found), of("", wanted)) is survives


def _stored(value, dtype):
    if np.issubdtype(dtype, np.integer):
        return np.iinfo(dtype).min <= value <= np.iinfo(dtype).max
    return int(dtype(value)) == value


class Colour(IntEnum):
    red = 1
    green = 2


class Huge(IntEnum):
    last = 2**40


class Paint(IntEnum):
    red = 1
    green = 3


def test_enumerations_fit_by_their_items():
    colour, paint = (of("1", Type.ENUMERATION, enumeration=Enumeration.of(e)) for e in (Colour, Paint))
    assert type_fits(colour, colour)
    assert not type_fits(colour, paint)
    assert type_fits(colour, of("1", Type.ENUMERATION))
    assert type_fits(colour, of("1", Type.INT64))
    assert type_fits(colour, of("1", Type.INT32))
    assert type_fits(of("1", Type.INT32), colour)
    assert not type_fits(of("1", Type.ENUMERATION), of("1", Type.INT32))
    assert not type_fits(of("1", Type.ENUMERATION, enumeration=Huge), of("1", Type.INT32))
    assert not type_fits(colour, of("1", Type.INT16))
    assert not type_fits(of("1", Type.INT64), colour)
    assert not type_fits(of("1", Type.FLOAT64), colour)
    assert not type_fits(of("1", Type.BOOLEAN), of("1", Type.INT32))
    assert not type_fits(of("1", Type.STRING), of("1", Type.BINARY))
