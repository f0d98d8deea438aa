"""Smoothness at matched accuracy; `test_claims` shows what follows from it for C1."""

from __future__ import annotations

import dataclasses

import pytest

from orchestrator.reproduction.paper import matched
from tests.orchestrator.reproduction.made_results import curve

METRICS = {"path_error_rms": 0.2, "r_total_variation": 5.0, "r_dot_rms": 0.6}


def test_a_point_of_the_curve_at_the_same_accuracy_is_taken_as_it_is():
    compared = matched.compare(METRICS, curve((0.1, 14, 2.0), (0.2, 8, 1.0)))
    assert compared.at == {"r_total_variation": 8, "r_dot_rms": 1.0}
    assert compared.runs == ("sweep-1",)
    assert compared.smoother


@pytest.mark.parametrize(
    ("points", "smoother", "run", "how"),
    [
        (((0.3, 14, 2.0), (0.5, 12, 1.9)), True, "sweep-0", "no gain is that accurate; its most accurate one"),
        (((0.3, 4, 0.5), (0.5, 3, 0.4)), None, "sweep-0", "no gain is that accurate; its most accurate one"),
        (((0.05, 4, 0.5), (0.1, 3, 0.4)), False, "sweep-1", "every gain is more accurate; its least accurate one"),
        (((0.05, 20, 3.0), (0.1, 15, 2.0)), None, "sweep-1", "every gain is more accurate; its least accurate one"),
    ],
)
def test_nothing_is_extrapolated_beyond_the_ends(points, smoother, run, how):
    compared = matched.compare(METRICS, curve(*points))
    assert (compared.smoother, compared.runs, compared.how) == (smoother, (run,), how)


def test_runs_that_ended_in_a_fault_are_no_points_of_the_curve():
    whole = curve((0.1, 14, 2.0), (0.3, 8, 1.0))
    broken = dataclasses.replace(whole, points=tuple(dataclasses.replace(p, finished=False) for p in whole.points))
    compared = matched.compare(METRICS, broken)
    assert (compared.smoother, compared.at, compared.how) == (None, {}, "no gain leads to the end of the run")
