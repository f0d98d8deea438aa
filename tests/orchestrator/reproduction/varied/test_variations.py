"""The cases of the varied set: drawn inside their ranges, and the same for the same seed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from orchestrator.reproduction.varied import variations

PLAN = variations.load()
CASES = [variations.draw(PLAN.ranges, 3, number) for number in range(60)]


def test_all_values_are_inside_their_ranges():
    for case in CASES:
        ranges = {**PLAN.ranges["common"], **PLAN.ranges[case.task]}
        assert case.drawn.keys() == ranges.keys()
        for name, drawn in case.drawn.items():
            values = np.atleast_1d(drawn)
            assert len(values) == ranges[name].count
            assert (values >= ranges[name].low).all(), name
            assert (values <= ranges[name].high).all(), name


def test_values_spread_over_their_ranges():
    for name, r in PLAN.ranges["common"].items():
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


def test_a_controller_is_given_the_edges_of_the_road_only_where_it_has_them():
    given = {
        c.controller: {setting.partition("=")[0] for setting in variations.settings_for(CASES[0], c)}
        for c in PLAN.controllers
    }
    edges = {"controller.y_left", "controller.y_right"}
    assert edges <= given["mpc_plus"]
    assert not edges & given["lqr"]
    assert all("controller.y_adjacent" in names for names in given.values())
