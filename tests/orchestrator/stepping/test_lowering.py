"""Units with a step of their own: multiples and parts of the macro step."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.interfaces.problem import RequestError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import block_source
from orchestrator.system.system import System
from tests.orchestrator.blocks import Gain, Held, Sum


def run(steps, ticks, algorithm="sequential"):
    made = System({"s": block_source(Sum()), "h": block_source(Held())}, {"h.a": "s.b", "s.a": "h.b"}, steps=steps)
    frame = simulate(made, h=0.5, until=0.5 * ticks, algorithm=algorithm)
    return frame["s.b.value"].tolist(), frame["h.b.value"].tolist()


@given(n=st.integers(1, 4), m=st.integers(1, 4), ticks=st.integers(0, 12))
@settings(max_examples=30)
def test_a_multiple_acts_at_its_own_ticks_and_holds_in_between(n, m, ticks):
    """By hand: h samples every n-th tick, s adds every m-th what h showed when its step began."""
    s, h, total, count, begun = [], [], 1.0, 0, 0.0
    for k in range(ticks + 1):
        if k and not k % m:
            total += begun
        if not k % n:
            count += 1
            shown = total + 1000 * count
        if not k % m:
            begun = shown
        s.append(total)
        h.append(shown)
    assert run({"h": Fraction(n), "s": Fraction(m)}, ticks) == (s, h)


@given(parts=st.integers(1, 5), ticks=st.integers(0, 5))
@settings(max_examples=20)
def test_a_part_steps_several_times_with_its_inputs_held(parts, ticks):
    s, h, total = [], [], 1.0
    for k in range(ticks + 1):
        s.append(total)
        h.append(total + 1000 * (k + 1))
        total += parts * h[-1]
    assert run({"s": Fraction(1, parts)}, ticks) == (s, h)


def test_a_multiple_in_a_jacobi_master():
    s, h = run({"h": Fraction(2)}, 4, "jacobi")
    assert h == [1001.0, 1001.0, 1001.0, 1001.0, 2000.0 + s[2]]
    assert s == [1.0, 1002.0, 2003.0, 3004.0, 4005.0]


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (
            {"g": Fraction(2, 3)},
            "step of `g`: found 2/3 macro steps; valid: a whole multiple of the macro step, or a whole part of it",
        ),
        (
            {"g": Fraction(-1)},
            "step of `g`: found -1 macro steps; valid: a whole multiple of the macro step, or a whole part of it",
        ),
        ({"x": Fraction(2)}, "step of `x`: found an unknown unit; valid: g"),
    ],
)
def test_steps_that_do_not_fit_are_refused(steps, message):
    with pytest.raises(RequestError) as error:
        System({"g": block_source(Gain(k=1.0))}, {}, held={"g.a.value": 1.0}, steps=steps)
    assert str(error.value) == message
