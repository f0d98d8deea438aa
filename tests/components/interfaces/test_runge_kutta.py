"""Runge-Kutta steps against the solutions of equations that have one on paper."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.runge_kutta import runge_kutta


@record
class Oscillator:
    """An oscillator of 1 rad/s, and something that decays."""

    position: float = quantity("m", "position")
    speed: float = quantity("m/s", "speed")
    decaying: float = quantity("1", "something that decays")


def derivative(x: Oscillator) -> Oscillator:
    return Oscillator(position=x.speed, speed=-x.position, decaying=-x.decaying)


START = Oscillator(position=1.0, speed=0.0, decaying=1.0)


def after(n: int) -> Oscillator:
    """The state after 1 s in `n` steps."""
    x = START
    for _ in range(n):
        x = runge_kutta(derivative, x, 1.0 / n)
    return x


@given(z=st.floats(-2, 2))
def test_a_step_along_an_exponential_is_its_series_up_to_the_fourth_power(z):
    x = runge_kutta(lambda x: Oscillator(position=0.0, speed=0.0, decaying=z * x.decaying), START, 1.0)
    assert x.decaying == pytest.approx(sum(z**k / math.factorial(k) for k in range(5)), rel=1e-13)


def test_the_error_falls_with_the_fourth_power_of_the_step():
    errors = {name: [] for name in ("position", "speed", "decaying")}
    exact = {"position": math.cos(1.0), "speed": -math.sin(1.0), "decaying": math.exp(-1.0)}
    for n in (8, 16, 32):
        x = after(n)
        for name, value in exact.items():
            errors[name].append(abs(getattr(x, name) - value))
    for found in errors.values():
        assert np.log2(np.array(found[:-1]) / found[1:]) == pytest.approx([4.0, 4.0], abs=0.25)
        assert found[-1] < 1e-6


@given(c=st.lists(st.floats(-5, 5), min_size=4, max_size=4), h=st.floats(0.01, 2))
def test_a_cubic_in_time_is_integrated_without_error(c, h):
    """The time is a state of slope 1."""

    def slope(x: Oscillator) -> Oscillator:
        return Oscillator(position=1.0, speed=sum(a * x.position**k for k, a in enumerate(c)), decaying=0.0)

    x = runge_kutta(slope, Oscillator(position=0.0, speed=0.0, decaying=0.0), h)
    assert x.speed == pytest.approx(sum(a * h ** (k + 1) / (k + 1) for k, a in enumerate(c)), rel=1e-12, abs=1e-12)
    assert x.position == pytest.approx(h, rel=1e-15)


def test_the_state_of_before_stays_and_symbols_go_through():
    x = runge_kutta(derivative, START, 0.1)
    assert (START.position, START.speed, START.decaying) == (1.0, 0.0, 1.0)
    v, h = ca.SX.sym("v", 3), ca.SX.sym("h")
    symbolic = runge_kutta(derivative, Oscillator(position=v[0], speed=v[1], decaying=v[2]), h)
    function = ca.Function("step", [v, h], [ca.vertcat(symbolic.position, symbolic.speed, symbolic.decaying)])
    found = np.asarray(function([1.0, 0.0, 1.0], 0.1)).ravel()
    assert found == pytest.approx([x.position, x.speed, x.decaying], rel=1e-15)
