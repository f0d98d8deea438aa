"""The times of a run where files leave them open."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.unit_interface import SuggestedExperiment
from orchestrator import Options, load
from orchestrator.scenario.suggested_times import deviations, suggested_step, whole_steps
from orchestrator.system.experiment import Scenario


@pytest.mark.parametrize(
    ("suggestions", "step", "why"),
    [
        ([], 0.1, ""),
        ([SuggestedExperiment()], 0.1, ""),
        ([SuggestedExperiment(step=0.02), SuggestedExperiment(step=0.05)], 0.02, "the smallest that its units prefer"),
        ([SuggestedExperiment(fixed_step=0.03)], 0.09, "whole internal steps of 0.03 s"),
        ([SuggestedExperiment(fixed_step=0.05)], 0.1, "whole internal steps of 0.05 s"),
        ([SuggestedExperiment(fixed_step=0.4)], 0.4, "whole internal steps of 0.4 s"),
    ],
)
def test_a_step_that_nobody_says_is_the_one_that_fits_the_units(suggestions, step, why):
    assert suggested_step(dict(enumerate(suggestions))) == (pytest.approx(step), why)


@given(
    start=st.floats(-100, 100),
    h=st.sampled_from([0.01, 0.1, 0.3, 1 / 3]),
    ticks=st.integers(0, 10**5),
    part=st.floats(0, 0.99),
)
def test_a_run_never_goes_beyond_the_stop_time_of_its_file(start, h, ticks, part):
    until = start + (ticks + part) * h
    last, remarks = whole_steps(start, h, until)
    assert start <= last <= until + 1e-9 * max(1.0, abs(until))
    assert until - last < h * (1 + 1e-6)
    assert bool(remarks) == (last != until)


def test_a_stop_time_before_the_start_stays_as_the_file_has_it():
    assert whole_steps(5.0, 0.5, 3.0) == (3.0, ())


def test_the_last_whole_step_is_told():
    assert whole_steps(0.0, 0.3, 1.0)[1] == (
        "the run ends at 0.9 s, the last whole step of 0.3 s before the file's stop time, 1 s",
    )


@dataclass(frozen=True)
class Wishing:
    suggested: SuggestedExperiment


def told(h, wished, start=0.0, steps=None):
    static = load("static", Options(mode="blocks"))
    system = replace(static.system, steps=steps or {})
    object.__setattr__(system, "units", {"plant": Wishing(wished)})
    return list(deviations(replace(static, system=system, h=h, start=start)))


@pytest.mark.parametrize(
    ("wished", "text"),
    [
        (
            SuggestedExperiment(fixed_step=0.03),
            "`plant` computes in steps of 0.03 s, of which its step of 0.1 s is no whole multiple: its results lie at"
            " other times than it is asked for",
        ),
        (
            SuggestedExperiment(step=0.03, any_step=False),
            "`plant` prefers steps of 0.03 s, and is not said to take others; it gets 0.1 s",
        ),
        (
            SuggestedExperiment(step=0.01),
            "`plant` prefers steps of 0.01 s, and gets 0.1 s: its results may be coarse, or grow without bound;"
            " `macrostep check FILE --passport` tries it",
        ),
        (
            SuggestedExperiment(start=5.0),
            "the experiment of `plant` has the start time 5 s; this run has 0 s",
        ),
    ],
)
def test_what_a_unit_suggests_and_does_not_get_is_told(wished, text):
    assert told(0.1, wished) == [text]


def test_what_a_unit_gets_is_not_told():
    assert told(0.1, SuggestedExperiment(step=0.03)) == []  # it takes others
    assert told(0.1, SuggestedExperiment(fixed_step=0.05, step=0.1, any_step=False)) == []
    assert told(0.1, SuggestedExperiment(start=5.0), start=5.0) == []
    assert told(0.1, SuggestedExperiment(fixed_step=0.2), steps={"plant": Fraction(2)}) == []


def test_a_scenario_says_its_times_as_a_grid():
    scenario = Scenario("s", "s", None, None, h=0.5, until=1.0, start=-1.0, sources={})
    assert scenario.grid.times.tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0]


def test_a_step_that_no_time_has_a_number_of():
    assert whole_steps(1.0, 5e-324, 1.0) == (1.0, ())
