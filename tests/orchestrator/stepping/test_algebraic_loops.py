"""Algebraic loops, solved on request."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.interfaces.problem import RequestError
from orchestrator.stepping.master import SimulationError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import InProcess, block_source
from orchestrator.system.system import System
from tests.orchestrator.blocks import Affine, Gain, Held, Sum, system
from tests.orchestrator.stepping.mixed import made

gains = st.floats(-5, 5)


@given(k=gains, d=gains, k_2=gains, d_2=gains)
@settings(max_examples=40)
def test_two_units_that_show_at_once_agree(k, d, k_2, d_2):
    """Against the solution of the two linear equations; the gain of the loop may be far above 1."""
    assume(abs(1 - k * k_2) > 0.1)
    made = system({"p": Affine(k=k, d=d), "q": Affine(k=k_2, d=d_2)}, {"p.a": "q.b", "q.a": "p.b"})
    frame = simulate(made, h=1.0, until=2.0, solve_loops=True)
    p = (k * d_2 + d) / (1 - k * k_2)
    assert frame["p.b.value"].tolist() == pytest.approx([p] * 3, abs=1e-7)
    assert frame["q.b.value"].tolist() == pytest.approx([k_2 * p + d_2] * 3, abs=1e-7)


def test_a_unit_that_shows_by_stepping_is_stepped_once_for_each_tick_whatever_the_iterations():
    """q shows what it samples, plus 1000 for each sample: its count tells how often it really stepped."""
    made = system({"p": Affine(k=-3.0, d=1.0), "q": Held()}, {"p.a": "q.b", "q.a": "p.b"})
    frame = simulate(made, h=1.0, until=3.0, solve_loops=True)
    expected = [(1 - 3000 * (k + 1)) / 4 for k in range(4)]  # p = 1 - 3 q, q = p + 1000 (k + 1)
    assert frame["p.b.value"].tolist() == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("again", [True, False])
def test_a_loop_of_values_that_are_no_floats_agrees_or_is_told(again):
    """The colour is shown as it is read; a flag is shown elsewhere than where it is read."""
    wiring = {"t.u.c": "t.y.c"} if again else {"t.u.b[2]": "t.y.b[3]", "t.u.b[1]": "t.y.b[1]"}
    values = {
        "t.u.a": 0.3,
        "t.u.v": [0.1, 0.2, 0.3],
        "t.u.s": 1.0,
        "t.u.n": 3,
        "t.u.c": 2,
        "t.u.b": [True, False, True],
    }
    held = {path: v for path, v in values.items() if path not in wiring}
    made_of = System({"t": made("through", None)}, wiring, held=held)
    frame = simulate(made_of, h=1.0, until=1.0, solve_loops=True)
    assert len(frame) == 2


def test_a_loop_beside_units_outside_it():
    made = system(
        {"s": Sum(), "p": Affine(k=0.5, d=1.0), "q": Gain(k=-1.0), "g": Gain(k=2.0)},
        {"p.a": "q.b", "q.a": "p.b", "s.a": "p.b", "g.a": "p.b"},
    )
    frame = simulate(made, h=1.0, until=3.0, solve_loops=True)
    p = 1 / 1.5
    assert frame["g.b.value"].tolist() == pytest.approx([2 * p] * 4)
    assert frame["s.b.value"].tolist() == pytest.approx([1 + k * p for k in range(4)])


def test_a_loop_without_a_solution_ends_the_run_and_names_the_chain():
    made = system({"p": Affine(k=1.0, d=1.0)}, {"p.a": "p.b"})
    with pytest.raises(SimulationError) as error:
        simulate(made, h=1.0, until=1.0, solve_loops=True)
    text = "tick 0 (t = 0 s), unit `p`: the algebraic loop p.b.value -> p.a.value has no solution near its last one"
    assert str(error.value).startswith(f"{text} at the start: inputs and outputs differ by ")


class NoWayBack(InProcess):
    """A unit that cannot save its state."""

    @property
    def interface(self) -> Any:
        return replace(super().interface, rolls_back=False)


def test_a_loop_through_a_unit_that_cannot_go_back_is_refused():
    held = block_source(Held())
    made = System(
        {"p": block_source(Gain(k=1.0)), "q": NoWayBack(held.block, held.parameters)}, {"p.a": "q.b", "q.a": "p.b"}
    )
    with pytest.raises(RequestError) as error:
        simulate(made, h=1.0, until=1.0, solve_loops=True)
    assert str(error.value).endswith(
        "found `q`, which cannot go back to where it was; valid: units that save and restore their state"
        " (canGetAndSetFMUState). Exchange values one step late: --algorithm jacobi."
    )


def test_a_loop_through_a_unit_with_its_own_step_is_refused():
    made = System(
        {"p": block_source(Gain(k=1.0)), "q": block_source(Held())},
        {"p.a": "q.b", "q.a": "p.b"},
        steps={"q": Fraction(2)},
    )
    with pytest.raises(RequestError, match="found `q`, which has a step of its own; valid: units that step with"):
        simulate(made, h=1.0, until=1.0, solve_loops=True)
