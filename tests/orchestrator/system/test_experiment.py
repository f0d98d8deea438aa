"""Algorithms, steps and stop times, and what is said of those that cannot be."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.problem import RequestError
from orchestrator.system.experiment import EVERYTHING, STEP, Algorithm, Scenario, TimeGrid, algorithm_named, macro_step


def test_an_unknown_algorithm_is_refused_with_those_there_are():
    with pytest.raises(RequestError) as error:
        algorithm_named("gauss")
    assert str(error.value) == "algorithm: found `gauss`; valid: clocked, jacobi, sequential"


@pytest.mark.parametrize("algorithm", Algorithm)
def test_an_algorithm_is_found_by_its_name(algorithm):
    assert algorithm_named(str(algorithm)) is algorithm


@pytest.mark.parametrize("h", [STEP, 1e-6, 3600.0])
def test_a_step_that_can_be_stepped_with_stays_as_it_is(h):
    assert macro_step(h) == h


@pytest.mark.parametrize(
    ("h", "found"), [(0.0, "0 s"), (-0.1, "-0.1 s"), (float("nan"), "nan s"), (float("inf"), "inf s")]
)
def test_a_step_that_is_none_is_refused(h, found):
    for refused in (macro_step, lambda h: TimeGrid(h, 1.0)):
        with pytest.raises(RequestError) as error:
            refused(h)
        assert str(error.value) == f"step: found {found}; valid: a positive number of seconds"


@pytest.mark.parametrize(
    ("h", "until", "ticks"), [(0.1, 0.0, 0), (0.1, 11.3, 113), (0.1, 0.3, 3), (0.05, 2.0, 40), (1 / 3, 1.0, 3)]
)
def test_a_run_ends_at_the_tick_of_its_stop_time(h, until, ticks):
    assert TimeGrid(h, until).last_tick == ticks


@given(ticks=st.integers(0, 10**6), h=st.sampled_from([0.1, 0.01, 0.05, 0.3, 1 / 3, 1e-3]))
def test_ticks_and_seconds_are_converted_both_ways(ticks, h):
    assert TimeGrid(h, ticks * h).last_tick == ticks


@pytest.mark.parametrize(
    ("until", "text"),
    [
        (-1.0, "stop time: found -1 s; valid: a number of seconds, 0 or more"),
        (float("inf"), "stop time: found inf s; valid: a number of seconds, 0 or more"),
        (float("nan"), "stop time: found nan s; valid: a number of seconds, 0 or more"),
        (0.25, "stop time: found 0.25 s; valid: a whole number of steps of 0.1 s. Try 0.2 s."),
        (0.27, "stop time: found 0.27 s; valid: a whole number of steps of 0.1 s. Try 0.3 s."),
    ],
)
def test_a_stop_time_that_no_tick_has_is_refused_with_the_nearest(until, text):
    with pytest.raises(RequestError) as error:
        TimeGrid(0.1, until)
    assert str(error.value) == text


def test_more_ticks_than_memory_holds_are_told():
    with pytest.raises(RequestError, match=r"^stop time: found 1e\+13 s, whose 1e\+14 steps of 0.1 s do not fit into"):
        _ = TimeGrid(0.1, 1e13).times


def test_a_scenario_records_everything_in_a_choice_of_its_own():
    first, second = (Scenario("s", "s", None, None, h=0.1, until=1.0, sources={}) for _ in range(2))
    assert first.record == second.record == EVERYTHING == {"*": 1}
    assert first.record is not second.record
    assert first.algorithm is Algorithm.SEQUENTIAL
