"""Verdicts and shares over all cases of the varied set."""

from __future__ import annotations

import pytest

from orchestrator.reproduction.paper.evidence import Result
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.varied import variations, varied_content
from orchestrator.reproduction.varied.varied_set import CaseResults, VariedSet

PLAN = variations.load()

METRICS = {
    "gap_obstacle": 1.0,
    "gap_edge": 0.1,
    "path_error_rms": 0.1,
    "path_error_max": 0.2,
    "r_dot_rms": 0.5,
    "delta_f_rate_rms": 0.1,
    "r_total_variation": 5.0,
    "r_peak": 0.5,
    "r_rms": 0.2,
    "r_dot_peak": 1.0,
    "r_sign_changes": 4.0,
}


def doctored(shares):
    """A varied set of static cases; MP is smoother than LQR where `shares` says, and `mpc_plus` touches in the last."""
    cases = []
    for number, smoother in enumerate(shares):
        lqr = {**METRICS, **({} if smoother else dict.fromkeys(METRICS, 0.01))}
        mp = {n: 0.5 * value for n, value in METRICS.items()}
        plus = {**METRICS, "gap_obstacle": float(number != len(shares) - 1)}
        rows = (
            ("mpc", RunRole.MP, "MP tuned", mp),
            ("lqr", RunRole.TWO_LEVEL, "LQR", lqr),
            ("mpc-plus", RunRole.PLUS, "+", plus),
        )
        results = {n: Result(n, "static", PLAN.plant, n, role, label, metrics) for n, role, label, metrics in rows}
        cases.append(CaseResults(variations.draw(PLAN.ranges, 3, 3 * number), results, {}))
    return VariedSet(PLAN, 3, tuple(cases))


@pytest.mark.parametrize(("smoother", "verdict"), [(20, "holds"), (19, "holds"), (18, "does not hold")])
def test_a_claim_holds_on_the_varied_set_where_it_holds_in_nearly_all_cases(smoother, verdict):
    told = varied_content.content(varied_content.judge(doctored([True] * smoother + [False] * (20 - smoother))))
    c3 = next(v for v in told["claims"] if v["claim"] == "C3")
    assert c3["verdict"] == verdict
    assert c3["cases"][0]["numbers"]["share"] == smoother / 20
    assert c3["cases"][0]["speaks_against"] == ([] if verdict == "holds" else ["r_dot_rms", "delta_f_rate_rms"])
    assert c3["decided_by"].endswith("in at least 95% of the variations that can be compared")


def test_shares_and_the_cases_that_are_left_to_look_at():
    found = doctored([True] * 4)
    told = varied_content.content(varied_content.judge(found))
    plus = next(c for c in told["controllers"] if c["name"] == "mpc-plus")
    assert (plus["no_contact"], plus["inside_road"], plus["both"]) == (0.75, 1.0, 0.75)
    assert told["unresolved"] == [9]
    assert told["cases"][3]["runs"]["mpc-plus"]["command"].startswith("macrostep run static --plant bicycle_saturated")
