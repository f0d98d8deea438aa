"""What varies in a sweep."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from components.interfaces.items import Enumeration, Item
from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity, Type
from orchestrator.sweeping.variation import split, twice, typed, value_problems, variation

MASS = Quantity("kg", "mass", min=1.0)
SPEED = Quantity("m/s", "speed")
COUNT = Quantity("1", "count", type=Type.INT32, min=0, max=9)
MODE = Quantity("1", "mode", type=Type.ENUMERATION, enumeration=Enumeration("Mode", (Item("slow", 1), Item("fast", 2))))
FLAG = Quantity("1", "flag", type=Type.BOOLEAN)
LIST = Quantity("m", "places", shape=(3,))


def numbers(values):
    return [float(value) for value in values]


def refused(text, quantity, path="plant.m"):
    with pytest.raises(RequestError) as error:
        variation(path, text, quantity)
    return str(error.value)


def test_a_range_is_uniform_from_end_to_end():
    mass = variation("plant.m", "1500:2500", MASS)
    assert numbers(mass.at(np.array([0.0, 0.25, 1.0]))) == [1500.0, 1750.0, 2500.0]
    assert numbers(mass.grid(3)) == [1500.0, 2000.0, 2500.0]
    assert numbers(mass.grid(1)) == [2000.0]


def test_a_logarithmic_range_is_uniform_in_its_logarithm():
    weight = variation("controller.b_3", "log:1e-3:1e-1", Quantity("1", ""))
    np.testing.assert_allclose(numbers(weight.at(np.array([0.0, 0.5, 1.0]))), [1e-3, 1e-2, 1e-1])
    np.testing.assert_allclose(numbers(weight.grid(3)), [1e-3, 1e-2, 1e-1])


def test_units_of_measurement_stand_behind_a_range_a_list_or_a_distribution():
    assert numbers(variation("plant.v", "36:72 [km/h]", SPEED).grid(2)) == [10.0, 20.0]
    listed = variation("plant.v", "36,72 [km/h]", SPEED)
    assert listed.choices == ("36 [km/h]", "72 [km/h]")
    assert typed(listed.choices, SPEED) == [10.0, 20.0]
    (middle,) = variation("plant.v", "normal:36,3.6 [km/h]", SPEED).at(np.array([0.5]))
    assert float(middle) == pytest.approx(10.0)


def test_whole_numbers_are_all_as_likely():
    count = variation("traffic.n", "2:5", COUNT)
    drawn = count.at(np.linspace(0, 1, 4000, endpoint=False))
    assert {n: drawn.count(n) for n in set(drawn)} == dict.fromkeys(["2", "3", "4", "5"], 1000)
    assert count.grid(100) == ["2", "3", "4", "5"]
    assert count.grid(2) == ["2", "5"]


@given(st.floats(0, 1, exclude_max=True))
def test_a_distribution_is_that_of_scipy(share):
    drawn = float(variation("plant.m", "gamma:2,1500,10", MASS).at(np.array([share]))[0])
    assert drawn == pytest.approx(stats.gamma(2, 1500, 10).ppf(min(max(share, 1e-12), 1 - 1e-12)))


@given(st.floats(0, 1, exclude_max=True), st.floats(-1e6, 1e6), st.floats(1e-3, 1e6))
def test_no_value_is_outside_of_its_range(share, low, width):
    text = f"{low!r}:{low + width!r}"
    (value,) = numbers(variation("plant.v", text, SPEED).at(np.array([share])))
    assert low <= value <= low + width


def test_lists_hold_names_truth_values_and_arrays():
    assert typed(variation("c.mode", "slow,fast", MODE).choices, MODE) == ["slow", "fast"]
    assert typed(variation("c.flag", "true,false", FLAG).choices, FLAG) == [True, False]
    assert variation("t.x", "[1,2,3],[4,5,6]", LIST).choices == ("[1,2,3]", "[4,5,6]")
    units = variation("plant", "bicycle,a.fmu", None)
    assert (units.is_filling, units.choices) == (True, ("bicycle", "a.fmu"))
    assert units.at(np.array([0.0, 0.4999, 0.5, 0.9999])) == ["bicycle", "bicycle", "a.fmu", "a.fmu"]


@pytest.mark.parametrize(
    ("text", "quantity", "told"),
    [
        ("2500:1500", MASS, "--vary plant.m=2500:1500: found a range from 2500 to 1500; valid: a range whose first"),
        ("-1:5", MASS, "--vary plant.m=-1:5: found -1; valid: 1 <= finite number [kg]"),
        ("log:-1:5", SPEED, "--vary plant.m=log:-1:5: found a logarithmic range from -1; valid: one from a number"),
        ("1:2:3", MASS, "--vary plant.m=1:2:3: found a range with 3 numbers; valid: LOW:HIGH, log:LOW:HIGH, a list"),
        ("", MASS, "--vary plant.m=: found nothing; valid: LOW:HIGH"),
        ("1,1", MASS, "--vary plant.m=1,1: found a value twice; valid: a list of different values"),
        ("slow:fast", MODE, "--vary plant.m=slow:fast: found a distribution; valid: a list A,B,C"),
        ("1:2", LIST, "--vary plant.m=1:2: found a range; valid: an element of it, such as plant.m[1]"),
        ("norml:1,2", MASS, "found the unknown distribution `norml`"),
        ("gamma:", MASS, "found parameters that `gamma` does not take"),
        ("normal:1,-2", MASS, "found parameters that `norm` does not take; valid: those of scipy.stats.norm"),
    ],
)
def test_what_cannot_vary_so_is_refused_in_words(text, quantity, told):
    assert told in refused(text, quantity)


def test_values_outside_of_what_a_parameter_takes_are_told_by_their_extremes():
    wide = variation("plant.m", "normal:3,1", MASS)
    values = wide.at(np.linspace(0.001, 0.999, 100))
    (problem,) = value_problems(wide, values, MASS)
    assert str(problem).startswith("--vary plant.m=normal:3,1: found -0.09")
    assert value_problems(variation("plant.m", "2:3", MASS), ["2.5"], MASS) == []
    listed = variation("c.mode", "slow,fats", MODE)
    assert "Did you mean `fast`?" in str(value_problems(listed, listed.choices, MODE)[0])


def test_a_request_is_a_path_and_its_values_once():
    assert split("traffic.v_final[1]=4:9") == ("traffic.v_final[1]", "4:9")
    for text in ("plant.m", "=3"):
        with pytest.raises(RequestError, match="valid: PATH=VALUES"):
            split(text)
    assert [str(p) for p in twice([("a.b", "1"), ("a.c", "1"), ("a.b", "2")])] == [
        "--vary a.b=2: found a path that varies twice; valid: each path once"
    ]
