"""Every verdict flips when the metrics do, both ways; what is not decided says so."""

from __future__ import annotations

import pytest

from orchestrator.reproduction.paper import claims
from orchestrator.reproduction.paper.evidence import AS_FMU, IN_PROCESS, Evidence, Result, Timing
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.paper.verdict import FAULT_NOTE, Status
from tests.orchestrator.reproduction.made_results import ROUGH, SMOOTH, curve, lqr, mp, result

CLAIMS = claims.CLAIMS


def decide(claim, *results, **more):
    return CLAIMS[claim](Evidence(tuple(results), **more))


def algorithms(**changed):
    """The evidence of C7 with some numbers changed."""
    values = {"distance": 1e-4, "failures": 0.0, "own": 20.0, "its": 100.0, **changed}
    reference = mp(solver_limits=values["failures"])
    other = result(RunRole.ALGORITHM, SMOOTH, "MP, SQP", controller="mpc_sqp")
    return Evidence(
        (reference, other),
        distances={other.name: values["distance"]},
        timings=(
            Timing("mpc", IN_PROCESS, values["own"], values["own"], 1.0, 1.0),
            Timing("mpc_sqp", IN_PROCESS, values["its"], values["its"], 1.0, 1.0),
        ),
        reference=reference.name,
    )


def times(mpc, other):
    made = (Timing("mpc", AS_FMU, mpc, mpc, 1.0, 1.0), Timing("lqr", AS_FMU, other, other, 1.0, 1.0))
    return Evidence((mp(), lqr()), timings=made)


def test_c1_holds_below_the_curve_at_the_same_path_error():
    assert decide("C1", mp(), curves=(curve((0.1, 14, 2.0), (0.3, 8, 1.0)),)).status is Status.HOLDS


@pytest.mark.parametrize("point", [(0.3, 8, 0.1), (0.3, -8, 1.0)], ids=["r_dot", "total variation"])
def test_c1_does_not_hold_where_the_curve_is_smoother_in_either_metric(point):
    verdict = decide("C1", mp(), curves=(curve((0.1, 14, 1.0), point),))
    assert verdict.status is Status.FAILS
    assert verdict.speaking_against == {"r_dot_rms" if point[2] < 1 else "r_total_variation": 1}


def test_c1_takes_the_numbers_of_the_curve_by_interpolation_and_names_the_runs():
    case = decide("C1", mp(), curves=(curve((0.1, 14, 2.0), (0.3, 8, 1.0)),)).cases[0]
    assert case.numbers["r_total_variation of LQR"] == pytest.approx(11)
    assert case.numbers["r_dot_rms of LQR"] == pytest.approx(1.5)
    assert case.runs == ("static-bicycle-MP tuned", "sweep-0", "sweep-1")


def test_c1_shows_a_curve_that_bends_back_at_its_best():
    bent = curve((0.1, 14, 2.0), (0.3, 8, 1.0), (0.1, 2, 0.3))
    case = decide("C1", mp(), curves=(bent,)).cases[0]
    assert not case.holds
    assert case.numbers["r_total_variation of LQR"] == pytest.approx(5)


def test_c1_is_dominated_by_a_curve_that_is_more_accurate_and_smoother_everywhere():
    assert decide("C1", mp(), curves=(curve((0.05, 4, 0.5), (0.1, 3, 0.4)),)).status is Status.FAILS


def test_c1_says_nothing_where_there_is_no_matched_accuracy():
    less_accurate_and_smoother = curve((0.3, 2, 0.3), (0.5, 1, 0.2))
    more_accurate_and_rougher = curve((0.05, 20, 3.0), (0.1, 15, 2.0))
    for found in (less_accurate_and_smoother, more_accurate_and_rougher):
        verdict = decide("C1", mp(), curves=(found,))
        assert verdict.status is Status.OPEN
        assert verdict.open_cases == ("MP tuned, LQR, linear",)


def test_c1_holds_where_no_gain_is_as_accurate_and_the_most_accurate_is_rougher():
    assert decide("C1", mp(), curves=(curve((0.3, 14, 2.0), (0.5, 12, 1.9)),)).status is Status.HOLDS


def test_c2_flips_with_either_path_error():
    accurate = {"path_error_rms": 0.2, "path_error_max": 0.5}
    assert decide("C2", mp(), lqr()).status is Status.HOLDS
    assert decide("C2", mp(path_error_rms=0.3), lqr(path_error_max=0.9)).status is Status.FAILS
    verdict = decide("C2", mp(**accurate), lqr(path_error_rms=0.3))
    assert verdict.outcome == "holds for MP tuned (1 of 2 cases)"
    assert verdict.speaking_against == {"path_error_rms": 1}


@pytest.mark.parametrize("claim", ["C3", "C4", "C5"])
def test_c3_to_c5_flip_with_who_is_smooth(claim):
    assert decide(claim, mp(SMOOTH), lqr(ROUGH)).status is Status.HOLDS
    assert decide(claim, mp(ROUGH), lqr(SMOOTH)).status is Status.FAILS


@pytest.mark.parametrize(
    ("claim", "metric"),
    [
        ("C3", "r_dot_rms"),
        ("C3", "delta_f_rate_rms"),
        ("C4", "r_peak"),
        ("C4", "r_rms"),
        ("C4", "r_dot_rms"),
        ("C5", "r_total_variation"),
        ("C5", "r_dot_peak"),
        ("C5", "r_sign_changes"),
    ],
)
def test_every_metric_that_decides_a_claim_can_bring_it_down(claim, metric):
    verdict = decide(claim, mp(**{metric: 100.0}), lqr())
    assert verdict.status is Status.FAILS
    assert verdict.speaking_against == {metric: 1}


def test_runs_are_compared_within_a_plant_only():
    saturated = lqr(SMOOTH, plant="bicycle_saturated")
    assert decide("C3", mp(), saturated).status is Status.OPEN


@pytest.mark.parametrize(
    "metrics",
    [{"gap_obstacle": 0.0}, {"gap_edge": -0.01}, {"corridor_violations": 1.0}, {"r_total_variation": 20.0}],
    ids=lambda m: next(iter(m)),
)
def test_c6_flips_with_contact_edge_corridor_and_smoothness(metrics):
    other = lqr(task="dynamic")
    assert decide("C6", mp(task="dynamic"), other).status is Status.HOLDS
    verdict = decide("C6", mp(task="dynamic", **metrics), other)
    assert verdict.status is Status.FAILS
    assert verdict.speaking_against == dict.fromkeys(metrics, 1)


def test_c6_is_about_moving_obstacles_only():
    assert decide("C6", mp(), lqr()).status is Status.OPEN


@pytest.mark.parametrize("changed", [{"distance": 0.02}, {"failures": 1.0}, {"own": 200.0}], ids=str)
def test_c7_flips_with_trajectory_failures_and_time(changed):
    assert CLAIMS["C7"](algorithms()).status is Status.HOLDS
    verdict = CLAIMS["C7"](algorithms(**changed))
    assert verdict.status is Status.FAILS
    assert verdict.speaking_against == {"p50_us" if name == "own" else name: 1 for name in changed}


def test_c8_flips_with_the_time_per_sample():
    assert CLAIMS["C8"](times(mpc=5.0, other=6.0)).status is Status.HOLDS
    assert CLAIMS["C8"](times(mpc=7.0, other=6.0)).status is Status.FAILS
    assert CLAIMS["C8"](times(mpc=7.0, other=6.0)).speaking_against == {"p50_us": 1}


@pytest.mark.parametrize(
    ("claim", "metric"),
    [("C2", "path_error_rms"), ("C2", "path_error_max"), ("C4", "r_peak"), ("C5", "r_sign_changes")],
)
def test_a_metric_that_is_no_number_speaks_against_a_claim(claim, metric):
    assert metric in decide(claim, mp(**{metric: float("nan")}), lqr()).speaking_against


@pytest.mark.parametrize("claim", CLAIMS)
def test_nothing_is_decided_without_runs(claim):
    assert decide(claim).status is Status.OPEN


@pytest.mark.parametrize("claim", ["C1", "C2", "C3", "C4", "C5"])
def test_a_run_that_ended_in_a_fault_decides_against_the_method_whatever_it_measured_before(claim):
    broken = Result("b", "static", "bicycle", "mpc", RunRole.MP, "MP tuned", {}, finished=False)
    found = curve((0.1, 14, 2.0), (0.3, 8, 1.0))
    verdict = decide(claim, broken, lqr(), curves=(found,))
    assert verdict.status is (Status.CONDITION if claim == "C2" else Status.FAILS)
    assert verdict.cases[0].note == FAULT_NOTE
    assert verdict.speaking_against == {}


def test_a_baseline_that_ended_in_a_fault_decides_nothing():
    broken = Result("b", "static", "bicycle", "lqr", RunRole.TWO_LEVEL, "LQR", {}, finished=False)
    assert decide("C3", mp(), broken).status is Status.OPEN


def test_claims_hold_for_some_settings_under_the_condition_that_names_them():
    literal = result(RunRole.MP, ROUGH, "MP literal", r_dot_rms=3.0, delta_f_rate_rms=2.0)
    verdict = decide("C3", mp(), literal, lqr())
    assert verdict.status is Status.CONDITION
    assert verdict.outcome == "holds with MP tuned (1 of 2 cases)"
    assert verdict.speaking_against == {"r_dot_rms": 1, "delta_f_rate_rms": 1}
