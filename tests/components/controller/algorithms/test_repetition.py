"""An iteration that is repeated until it is done: how often it is called, and what becomes of it in C."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from components.controller.algorithms.repetition import repeated

BOUND = 5


def halved() -> ca.Function:
    """Halves a pair and counts, until its first number is at most `least`."""
    pair, count, least = ca.SX.sym("pair", 2), ca.SX.sym("count"), ca.SX.sym("least")
    return ca.Function("halved", [pair, count, least], [pair / 2, count + 1, pair[0] / 2 <= least])


def search(first: float, least: float) -> tuple[list[float], float]:
    pair, count = repeated(halved(), BOUND)([first, -first], 0, least)
    return np.asarray(pair).ravel().tolist(), float(count)


@pytest.mark.parametrize(("least", "count"), [(4.0, 1), (1.0, 3), (0.25, 5)])
def test_it_ends_when_it_is_done(least, count):
    assert search(8.0, least) == ([8.0 / 2**count, -8.0 / 2**count], count)


@pytest.mark.parametrize("least", [0.0, float("nan")])
def test_the_bound_ends_what_is_never_done(least):
    assert search(8.0, least) == ([8.0 / 2**BOUND, -8.0 / 2**BOUND], BOUND)


def test_what_is_not_a_number_is_not_done():
    pair, count = search(float("nan"), 1.0)
    assert np.isnan(pair).all()
    assert count == BOUND


def c_of(function: Any) -> str:
    generator = ca.CodeGenerator("search.c", {"with_export": False})
    generator.add(function)
    return generator.dump()


def test_in_c_it_stands_once_behind_an_if():
    text = c_of(repeated(halved(), BOUND))
    assert text.count("/* halved:") == 1
    assert text.count("if (arg[0] ? casadi_to_int(*arg[0]) : 0) {") == 1
    assert "alloc(" not in text
    assert text == c_of(repeated(halved(), BOUND))
