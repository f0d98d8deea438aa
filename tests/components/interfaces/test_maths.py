"""The same text computes the same with numbers and with symbols."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces import maths

finite = st.floats(-50, 50)
EXPRESSIONS = {
    "sin": lambda v: maths.sin(v[0]),
    "cos": lambda v: maths.cos(v[0]),
    "tan": lambda v: maths.tan(v[0] / 50),
    "acos": lambda v: maths.acos(v[0] / 51),
    "tanh": lambda v: maths.tanh(v[0]),
    "atan2": lambda v: maths.atan2(v[0], v[1]),
    "sqrt": lambda v: maths.sqrt(v[0] * v[0]),
    "exp": lambda v: maths.exp(v[0] / 10),
    "fmin": lambda v: maths.fmin(v[0], v[1]),
    "fmax": lambda v: maths.fmax(v[0], v[1]),
    "both": lambda v: maths.where(maths.both(v[0] > 0, v[1] > 0), 1.0, 0.0),
    "either": lambda v: maths.where(maths.either(v[0] > 0, v[1] > 0), 1.0, 0.0),
    "negate": lambda v: maths.where(maths.negate(v[0] > v[1]), 1.0, 0.0),
    "where": lambda v: maths.where(v[0] < v[1], v[0], 2 * v[1]),
    "absolute": lambda v: maths.absolute(v[0]),
    "sign": lambda v: maths.sign(v[0]),
    "clip": lambda v: maths.clip(v[0], -1.0, 2.0),
    "largest": lambda v: maths.largest([v[0], v[1], 1.0]),
    "smallest": lambda v: maths.smallest([v[0], v[1], 1.0]),
    "vector": lambda v: maths.vector([v[0], 3.0, v[1]])[2],
    "joined": lambda v: maths.joined([maths.vector([v[0], v[1]]), maths.vector([v[1], v[0]])])[3],
}


@pytest.mark.parametrize("name", EXPRESSIONS)
@pytest.mark.parametrize("graph", [ca.SX, ca.MX])
@given(a=finite, b=finite)
def test_numbers_and_symbols_agree(name, graph, a, b):
    symbols = graph.sym("v", 2)
    lowered = ca.Function("f", [symbols], [EXPRESSIONS[name](symbols)])
    numbers = np.array([a, b])
    assert float(lowered(numbers)) == pytest.approx(float(EXPRESSIONS[name](numbers)), rel=1e-15, abs=1e-15)


@pytest.mark.parametrize("graph", [ca.SX, ca.MX])
def test_the_branch_that_is_not_taken_may_be_no_number(graph):
    x = graph.sym("x")
    lowered = ca.Function("f", [x], [maths.where(x > 0, maths.sqrt(x), 7.0), maths.where(x <= 0, 7.0, maths.sqrt(x))])
    assert [float(v) for v in lowered(-1.0)] == [7.0, 7.0]
    assert [float(v) for v in lowered(4.0)] == [2.0, 2.0]
    assert maths.where(np.bool_(0), float("nan"), 7.0) == 7.0


def test_arrays_of_symbols_and_numbers_are_taken_element_by_element():
    x = ca.SX.sym("x")
    y = np.array([x, 2.0], dtype=object)
    found = maths.atan2(y, np.array([1.0, 0.5], dtype=object))
    lowered = ca.Function("f", [x], [found[0], found[1], maths.hypot(y, 3.0)[0], maths.cos(y)[1]])
    assert [float(v) for v in lowered(4.0)] == [np.arctan2(4.0, 1.0), np.arctan2(2.0, 0.5), 5.0, np.cos(2.0)]


def test_joining_nothing_gives_an_empty_column():
    assert maths.joined([]).shape == (0,)


@pytest.mark.parametrize("value", [0.0, -9.9, 9.9, 10.0, -10.5, np.inf, -np.inf, np.nan])
@pytest.mark.parametrize("other", [1.0, np.nan])
def test_a_number_is_below_its_limit_and_no_nan(value, other):
    symbols = ca.SX.sym("v", 2)
    function = ca.Function("known", [symbols], [maths.is_number(symbols[0], symbols[1], limit=10.0)])
    expected = abs(value) < 10 and other == 1.0
    assert bool(maths.is_number(value, other, limit=10.0)) is expected
    assert bool(function([value, other])) is expected
    assert bool(maths.is_number(value)) is bool(np.isfinite(value))
