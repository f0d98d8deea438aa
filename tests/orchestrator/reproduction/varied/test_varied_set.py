"""The varied set: drawn inside its ranges, reproducible, and each case can be run again by its command."""

from __future__ import annotations

import shlex
from itertools import pairwise

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from orchestrator.reproduction import runs
from orchestrator.reproduction.paper.evidence import Result
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.varied import variations, varied_content, varied_set
from orchestrator.reproduction.varied.varied_set import CaseResults, VariedSet
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import simulate

FOUND = variations.load()
CASES = [variations.draw(FOUND.ranges, 3, number) for number in range(60)]


def test_all_values_are_inside_their_ranges():
    for case in CASES:
        ranges = {**FOUND.ranges["common"], **FOUND.ranges[case.task]}
        assert case.drawn.keys() == ranges.keys()
        for name, drawn in case.drawn.items():
            values = np.atleast_1d(drawn)
            assert len(values) == ranges[name].count
            assert (values >= ranges[name].low).all(), name
            assert (values <= ranges[name].high).all(), name


def test_values_spread_over_their_ranges():
    for name, r in FOUND.ranges["common"].items():
        values = np.concatenate([np.atleast_1d(case.drawn[name]) for case in CASES])
        assert values.min() < r.low + 0.2 * (r.high - r.low)
        assert values.max() > r.high - 0.2 * (r.high - r.low)


def test_a_seed_gives_the_same_cases_however_many_and_another_seed_others():
    few, many = variations.request(3, seed=3).cases, variations.request(6, seed=3).cases
    assert few == many[:3] == tuple(CASES[:3])
    assert variations.request(3, seed=4).cases != few


def test_tasks_take_turns():
    assert [case.task for case in CASES[:4]] == ["static", "dynamic", "dynamic-slow", "static"]


@pytest.mark.parametrize(("count", "seed"), [(0, 1), (-2, 1), (1, -1)])
def test_what_cannot_be_drawn_is_refused(count, seed):
    with pytest.raises(RequestError, match="--varied: found|--seed: found"):
        variations.request(count, seed)


def test_obstacles_do_not_overlap_at_the_start():
    for case in CASES:
        traffic = case._traffic()
        places = sorted(zip(traffic["y_start"], traffic["x_start"], strict=True))
        for (y, x), (other_y, other_x) in pairwise(places):
            assert abs(y - other_y) > 1.8 or abs(x - other_x) > 4.6


def test_the_controller_keeps_the_nominal_mass_and_knows_the_friction():
    settings = CASES[0].settings()
    assert any(text.startswith("plant.m=") for text in settings)
    assert not any(text.startswith("controller.m=") for text in settings)
    assert f"controller.mu={CASES[0].drawn['mu']}" in settings
    assert f"plant.v_x_start={CASES[0].drawn['v']}" in settings
    assert f"controller.v_ref={CASES[0].drawn['v']}" in settings


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_case_run_again_by_its_command_gives_the_same_rows(number, built_fmus):
    case = CASES[number]
    driver = next(d for d in FOUND.controllers if d.name == ("lqr-light" if number == 0 else "mpc-literal"))
    words = shlex.split(variations.command(case, driver, FOUND.plant))
    options = dict(pairwise(words))
    made = prepare(
        words[2],
        Options(
            mode=runs.MODE,
            replacements={"plant": options["--plant"], "controller": options["--controller"]},
            settings=[value for name, value in pairwise(words) if name == "--set"],
            stop_time=float(options["--stop-time"]),
        ),
    )
    again = simulate(made.system, h=made.h, until=made.until)
    varied_set.simulate(CASES[number + 3], driver, FOUND.plant)  # so that the FMUs have been used before
    frame, scene, fault = varied_set.simulate(case, driver, FOUND.plant)
    assert not fault
    assert scene == made.scene or vars(scene) == vars(made.scene)
    np.testing.assert_array_equal(frame.to_numpy(float), again.to_numpy(float))


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
    driven = []
    for number, smoother in enumerate(shares):
        lqr = {**METRICS, **({} if smoother else dict.fromkeys(METRICS, 0.01))}
        mp = {n: 0.5 * value for n, value in METRICS.items()}
        plus = {**METRICS, "gap_obstacle": float(number != len(shares) - 1)}
        rows = (
            ("mpc", RunRole.MP, "MP tuned", mp),
            ("lqr", RunRole.TWO_LEVEL, "LQR", lqr),
            ("mpc-plus", RunRole.PLUS, "+", plus),
        )
        results = {n: Result(n, "static", FOUND.plant, n, role, label, metrics) for n, role, label, metrics in rows}
        driven.append(CaseResults(CASES[3 * number], results, {}))
    return VariedSet(FOUND, 3, tuple(driven))


@pytest.mark.parametrize(("smoother", "verdict"), [(20, "holds"), (19, "holds"), (18, "does not hold")])
def test_a_claim_holds_on_the_varied_set_where_it_holds_in_nearly_all_cases(smoother, verdict):
    told = varied_content.content(varied_content.judge(doctored([True] * smoother + [False] * (20 - smoother))))
    c3 = next(v for v in told["claims"] if v["claim"] == "C3")
    assert c3["verdict"] == verdict
    assert c3["cases"][0]["numbers"]["share"] == smoother / 20
    assert c3["decided_by"].endswith("in at least 95% of the variations that can be compared")


def test_shares_and_the_cases_that_are_left_to_look_at():
    found = doctored([True] * 4)
    told = varied_content.content(varied_content.judge(found))
    plus = next(c for c in told["controllers"] if c["name"] == "mpc-plus")
    assert (plus["no_contact"], plus["inside_road"], plus["both"]) == (0.75, 1.0, 0.75)
    assert told["unresolved"] == [9]
    assert told["cases"][3]["runs"]["mpc-plus"]["command"].startswith("macrostep run static --plant bicycle_saturated")
