"""The search for failures."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity
from orchestrator.scenario.options import Options
from orchestrator.sweeping.journal import VariantResult
from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.sampling import SEARCH, Sampling
from orchestrator.sweeping.search import Budget, FailureSearch, read_aim, read_budget
from orchestrator.sweeping.sweep import sweep
from orchestrator.sweeping.sweep_request import SweepRequest
from orchestrator.sweeping.variation import variation

PATHS = ("p.a", "p.b")


def search_for(gap, budget="600", find="gap < 0", seed=0, clock=None):
    """A search over the unit square, where `gap(a, b)` takes the place of a simulation."""
    variations = tuple(variation(path, "0:1", Quantity("1", "")) for path in PATHS)
    request = SweepRequest("s", (), seed=seed, find=find, budget=budget)
    columns = {path: [] for path in PATHS}
    planned = PlannedSweep(
        request, Sampling(SEARCH), variations, columns, dict.fromkeys(PATHS), {"": SimpleNamespace()}
    )

    def run(variants):
        for variant in reversed(list(variants)):  # results come in any order
            a, b = (float(text.partition("=")[2]) for text in variant.settings)
            yield VariantResult(variant.number, 0.0, {"gap": gap(a, b)}, {"fine": gap(a, b) >= 0})

    return FailureSearch(planned, run, **({} if clock is None else {"clock": clock}))


def two_holes(a, b):
    """A plane with a deep hole and one that is not: 0.4 % and 0.2 % of it."""
    deep = np.hypot(a - 0.2, b - 0.8) - 0.036
    shallow = 0.5 * (np.hypot(a - 0.75, b - 0.3) - 0.025)
    return float(min(deep, shallow))


@pytest.mark.parametrize("seed", range(5))
def test_it_finds_what_a_fine_grid_finds_with_a_tenth_of_its_runs(seed):
    edge = np.linspace(0, 1, 80)
    grid = [(a, b) for a in edge for b in edge if two_holes(a, b) < 0]
    assert {a < 0.5 for a, _ in grid} == {True, False}, "the grid finds both, with 6400 runs"
    search = search_for(two_holes, budget="640", seed=seed)
    search.go()
    assert len(search.places) <= 640
    found = [search.places[number] for number in search.distinct()]
    assert {place[0] < 0.5 for place in found} == {True, False}
    assert search.margins[search.distinct()[0]] == min(search.margins)


def test_failures_are_distinct_and_the_mildest_is_near_the_middle():
    search = search_for(lambda a, _: 0.9 - a)
    search.go()
    places = [search.places[number] for number in search.distinct()]
    assert 2 <= len(places) <= 8
    assert min(np.linalg.norm(p - q) for i, p in enumerate(places) for q in places[:i]) >= 0.15 * np.sqrt(2)
    a, b = search.places[search.mildest()]
    assert 0.9 < a < 0.95
    assert abs(b - 0.5) < 0.3


def test_the_same_seed_looks_at_the_same_variants():
    one, other, another = (search_for(two_holes, "200", seed=seed) for seed in (1, 1, 2))
    for search in (one, other, another):
        search.go()
    assert one.planned.columns == other.planned.columns != another.planned.columns
    assert len(one.places) == 200


def test_where_nothing_fails_it_ends_and_says_so():
    search = search_for(lambda a, b: 1 + a * b, budget="10000")
    search.go()
    assert search.distinct() == []
    assert search.mildest() is None
    assert len(search.places) < 1000, "one search, not the whole budget"


def test_variants_with_the_same_values_are_run_once_and_are_one_failure():
    search = search_for(lambda a, b: 0.5 - a)
    search.planned = replace(search.planned, variations=tuple(variation(p, "0,1", Quantity("1", "")) for p in PATHS))
    search.go()
    assert len(search.places) <= 4
    assert sorted(search.planned.columns["p.a"][n] for n in search.distinct()) == ["1", "1"]


def test_time_is_a_budget_as_well():
    now = iter(np.arange(0.0, 1000.0))
    search = search_for(lambda a, _: 0.5 - a, budget="3s", clock=lambda: next(now))
    search.go()
    assert len(search.places) < 200


def test_a_verdict_and_a_fault_can_be_looked_for():
    search = search_for(two_holes, find="not fine")
    search.go()
    assert all(two_holes(*search.places[n]) < 0 for n in search.distinct())
    fault = read_aim("fault")
    assert fault.margin(VariantResult(0, 0.0, {}, {}, "it died")) < 0 < fault.margin(VariantResult(0, 0.0, {}, {}))


@pytest.mark.parametrize(
    ("text", "value", "fails"),
    [
        ("x < 1", 1.0, False),
        ("x <= 1", 1.0, True),
        ("x > 1", 1.5, True),
        ("x >= -2e-1", -0.2, True),
        ("x>1", 0.5, False),
    ],
)
def test_a_bound_is_crossed_or_reached(text, value, fails):
    assert (read_aim(text).margin(VariantResult(0, 0.0, {"x": value}, {})) <= 0) is fails
    assert read_aim(text).margin(VariantResult(0, 0.0, {}, {})) == np.inf


@pytest.mark.parametrize("text", ["gap_edge", "< 0", "gap_edge < low", "gap_edge = 0", "not", "a < 1 < 2", ""])
def test_an_expression_of_another_form_is_refused(text):
    with pytest.raises(RequestError, match="valid: METRIC < NUMBER, METRIC > NUMBER, not VERDICT, or fault"):
        read_aim(text)


def test_budgets():
    assert read_budget("60s") == Budget(seconds=60)
    assert read_budget("1.5 min") == Budget(seconds=90)
    assert read_budget("500") == Budget(variants=500)
    for text in ("", "0s", "-3", "soon", "1.5", "3 days"):
        with pytest.raises(RequestError, match="valid: 60s, 10min, 1h, or a number of variants"):
            read_budget(text)


def test_what_nobody_measures_is_refused_after_the_first_variant_and_nothing_is_left(built_fmus, in_tmp_path):
    varied = {"plant.m": "1500:2500"}
    options = Options(stop_time=3.0)
    with pytest.raises(RequestError) as error:
        sweep("static", varied, find="gap_edg < 0", options=options, executor=ThreadPoolExecutor(1))
    assert str(error.value).startswith("--find gap_edg < 0: found no metric `gap_edg`; valid: a_y_peak, ")
    assert str(error.value).endswith("Did you mean `gap_edge`?")
    assert list((in_tmp_path / "runs").iterdir()) == []


@pytest.mark.slow
def test_what_is_found_is_kept_and_told(built_fmus, macrostep, in_tmp_path):
    line = ("static", "--vary", "plant.m=1500:2500", "--vary", "controller.b_3=log:1e-3:1e-1", "--on", "threads")
    code, out, _ = macrostep("sweep", *line, "--find", "gap_edge < -0.3", "--budget", "60", "--out", "f")
    assert code == 0
    told = json.loads((in_tmp_path / "f" / "sweep.json").read_text())
    kept = {path.name for path in (in_tmp_path / "f" / "runs").iterdir()}
    assert kept == {f"variant-{n}" for n in {*told["found"], told["mildest"]}}
    assert told["found"]
    for name in kept:
        metrics = json.loads((in_tmp_path / "f" / "runs" / name / "summary.json").read_text())["metrics"]
        assert metrics["gap_edge"] < -0.3
    assert "gap_edge < -0.3: " in out
    assert f"  variant {told['mildest']}, the mildest (plant.m=" in out
    code, _, err = macrostep("sweep", "f")
    assert (code, "found a search; valid: a sweep of samples. Begin it anew." in err) == (2, True)


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["static", "dynamic-slow"])
def test_in_a_scenario_it_finds_what_a_grid_finds_with_a_tenth_of_its_runs(scenario, built_fmus, in_tmp_path):
    varied = {"plant.m": "1500:2500", "controller.b_3": "log:1e-3:1e-1"}
    grid = sweep(scenario, varied, grid="20", keep=())
    assert 0.05 < (grid["gap_edge"] < -0.2).mean() < 0.15, "a few of 400 fail"
    found = sweep(scenario, varied, find="gap_edge < -0.2", budget="40", seed=1, keep=())
    assert len(found) <= 40
    assert found["gap_edge"].min() < -0.2
