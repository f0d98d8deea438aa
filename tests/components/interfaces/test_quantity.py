"""Declarations and values of quantities: what is refused, and in which words."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import pytest

from components.interfaces.items import Enumeration
from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity, Type, boolean, enumeration, integer, quantity
from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT


class Colour(IntEnum):
    red = 1
    green = 4


def refusal(call, *arguments, **named) -> str:
    with pytest.raises(RequestError) as caught:
        call(*arguments, **named)
    return str(caught.value)


def said(declared: Quantity, value: object) -> str:
    return "\n".join(map(str, declared.problems("plant.m", value)))


def test_an_unknown_unit_is_refused_with_the_units_there_are():
    text = refusal(quantity, "km/h", "speed")
    assert text == f"quantity `speed`: found unit `km/h`; valid: {', '.join(sorted(UNITS_OF_MEASUREMENT))}"


@pytest.mark.parametrize(
    "declare", [lambda: quantity("m", ""), lambda: integer(""), lambda: boolean(""), lambda: enumeration(Colour, "")]
)
def test_a_quantity_without_description_is_refused(declare):
    assert refusal(declare) == "quantity: found no description; valid: a phrase that says what it means"


def test_a_minimum_above_the_maximum_is_refused():
    assert refusal(quantity, "m", "gap", min=2, max=1) == "quantity `gap`: found min 2 above max 1; valid: min <= max"
    assert refusal(integer, "count", min=1, max=0) == "quantity `count`: found min 1 above max 0; valid: min <= max"


def test_a_range_of_one_value_is_allowed():
    declared = quantity("m", "gap", min=1, max=1).metadata["quantity"]
    assert said(declared, 1.0) == ""


@pytest.mark.parametrize(
    ("declared", "text"),
    [
        (Quantity("m", "d"), "finite number [m]"),
        (Quantity("1", "d", min=0), "0 <= finite number"),
        (Quantity("1", "d", max=2), "finite number <= 2"),
        (Quantity("kg", "d", min=0.5, max=2), "0.5 <= finite number <= 2 [kg]"),
        (Quantity("1", "d", Type.INT32, min=0), "0 <= whole number"),
        (Quantity("1", "d", Type.BOOLEAN), "true or false"),
        (Quantity("1", "d", Type.ENUMERATION, enumeration=Enumeration.of(Colour)), "green, red"),
    ],
)
def test_the_valid_values_read_as_text(declared, text):
    assert declared.range == text


MASS = Quantity("kg", "mass", min=1, max=9)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "plant.m: found 0.5; valid: 1 <= finite number <= 9 [kg]"),
        (9.5, "plant.m: found 9.5; valid: 1 <= finite number <= 9 [kg]"),
        (float("nan"), "plant.m: found nan; valid: 1 <= finite number <= 9 [kg]"),
        (float("inf"), "plant.m: found inf; valid: 1 <= finite number <= 9 [kg]"),
        (True, "plant.m: found `True` (true/false); valid: 1 <= finite number <= 9 [kg]"),
        ("heavy", "plant.m: found `heavy` (not a number); valid: 1 <= finite number <= 9 [kg]"),
        (None, "plant.m: found `None` (not a number); valid: 1 <= finite number <= 9 [kg]"),
        ([2.0], "plant.m: found shape (1,); valid: shape ()"),
        ([2.0, [3.0]], "plant.m: found `[2.0, [3.0]]` (not an array); valid: 1 <= finite number <= 9 [kg]"),
    ],
)
def test_a_wrong_number_is_named_with_what_would_be_valid(value, text):
    assert said(MASS, value) == text


@pytest.mark.parametrize("value", [1, 1.0, 9, np.float64(5.0), np.int32(2), np.array(3.0)])
def test_numbers_inside_the_range_whole_or_not_are_fine(value):
    assert said(MASS, value) == ""


def test_an_array_is_judged_element_by_element_and_by_its_shape():
    declared = Quantity("m", "gaps", shape=(3,), min=0)
    assert said(declared, [0.0, 1.0, 2.0]) == ""
    assert said(declared, [0.0, -1.0, -2.0]) == "plant.m: found -1.0; valid: 0 <= finite number [m]"
    assert said(declared, [0.0, 1.0]) == "plant.m: found shape (2,); valid: shape (3,)"
    assert said(declared, 0.0) == "plant.m: found shape (); valid: shape (3,)"
    assert said(declared, [0.0, float("nan"), 1.0]) == "plant.m: found nan; valid: 0 <= finite number [m]"


def test_a_whole_number_may_not_have_a_fraction():
    declared = Quantity("1", "count", Type.INT32)
    assert said(declared, 3) == ""
    assert said(declared, 3.0) == "plant.m: found `3.0` (number); valid: whole number"
    assert said(declared, value=True) == "plant.m: found `True` (true/false); valid: whole number"


def test_a_truth_value_is_no_number():
    declared = Quantity("1", "valid", Type.BOOLEAN)
    assert said(declared, value=False) == ""
    assert said(declared, 1) == "plant.m: found `1` (whole number); valid: true or false"


def test_an_enumeration_takes_its_items_only():
    declared = Quantity("1", "colour", Type.ENUMERATION, enumeration=Enumeration.of(Colour))
    assert said(declared, Colour.green) == ""
    assert said(declared, 4) == ""
    assert said(declared, 2) == "plant.m: found 2; valid: green, red"
