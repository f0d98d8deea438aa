"""Signals over all variants: what is kept of which, and their mean and percentiles.

Shows `watched_signals.py` and `bands.py`.
"""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.loading import load
from orchestrator.results.run_folder import SIGNALS
from orchestrator.scenario.options import Options
from orchestrator.sweeping import plan as plan_module
from orchestrator.sweeping import sweep_folder
from orchestrator.sweeping.bands import PERCENTILES, band_table
from orchestrator.sweeping.engine import workforce
from orchestrator.sweeping.sweep import go_on, sweep
from orchestrator.sweeping.watched_signals import WatchedSignals, _problems, _usual, watched_signals
from tests.orchestrator.sweeping.test_findings import planned

SHORT = Options(stop_time=2.0)


def kept(*courses, share=1.0, every_row=1):
    """A plan and what is kept of its variants, in which the signal `s` had these values in each variant."""
    watched = WatchedSignals({"s": "m"}, share, every_row)
    rows = [{"s": np.array(course, dtype=float)} for course in courses]
    results = {n: signals for n, row in enumerate(rows) if (signals := watched.taken(n, row))}
    return replace(planned(len(courses)), watched=watched), results


@given(st.lists(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=5), min_size=1, max_size=8), st.randoms())
def test_mean_and_percentiles_are_those_of_the_variants_that_lasted_so_long(courses, random):
    plan, results = kept(*courses)
    order = list(results)
    random.shuffle(order)
    table = band_table(plan, {n: results[n] for n in order})
    assert table.equals(band_table(plan, results))
    longest = max(map(len, courses))
    assert list(table["tick"]) == list(range(longest))
    assert list(table["time"]) == [plan.scenario.h * tick for tick in range(longest)]
    for tick, row in enumerate(table.to_dict("records")):
        there = [course[tick] for course in courses if len(course) > tick]
        assert row["variants"] == len(there)
        found = [row[name] for name in ("mean", *PERCENTILES)]
        assert found == pytest.approx([np.mean(there), *np.percentile(there, [0, 5, 50, 95, 100])], rel=1e-12, abs=1e-9)


def test_values_that_are_no_numbers_do_not_count():
    table = band_table(*kept([1.0, np.nan, np.nan], [3.0, 5.0, np.inf]))
    assert list(table["tick"]) == [0, 1]
    assert list(table["mean"]) == [2.0, 5.0]
    assert list(table["variants"]) == [2, 1]


def test_of_many_rows_some_are_kept():
    table = band_table(*kept([0, 1, 2, 3, 4], [2, 3, 4, 5, 6], every_row=2))
    assert list(table["tick"]) == [0, 2, 4]
    assert list(table["mean"]) == [1, 3, 5]


@pytest.mark.parametrize("factor", [1, 2, 3, 4, 7, 10, 64, 600])
def test_of_very_many_variants_some_are_kept_of_every_value_of_a_grid(factor):
    watched, count = WatchedSignals({"s": "m"}, 1024 / 120_000), 120_000
    taken = np.array([watched.takes(n) for n in range(count)])
    assert 900 < taken.sum() < 1150
    for value in range(factor):
        assert taken[value::factor].sum() == pytest.approx(1024 / factor, rel=0.5, abs=2)


def test_so_many_are_kept_that_memory_and_folder_stay_small(built_fmus):
    scenarios = {"": load("static", Options(mode="blocks", stop_time=1000.0))}
    watched = watched_signals((), scenarios, 100_000)
    assert watched == WatchedSignals({"plant.state.y": "m", "plant.state.v_x": "m/s"}, 0.01024, 20)
    assert re.search(r"the whole range of 10[0-9]{2} of 100000 variants, evenly spread", watched.in_words(100_000))
    assert "of all variants" in watched.in_words(1)


def test_signals_are_of_one_unit_of_measurement_whatever_fills_a_socket():
    """In units that a socket varies over, a number must not mean one thing here and another there."""
    known = {"plant=a": {"plant.state.v_x": "m/s"}, "plant=b": {"plant.state.v_x": "km/h"}}
    assert [str(problem) for problem in _problems(["plant.state.v_x"], known)] == [
        "--signals plant.state.v_x: found [m/s] with plant=a, [km/h] with plant=b; valid: one unit of measurement in"
        " all units. Sweep them one by one."
    ]
    static = load("static", Options(mode="blocks"))
    of_plant = {"plant.state.y": "m", "plant.state.v_x": "m/s"}
    other = {**of_plant, "plant.state.v_x": "km/h"}
    assert list(_usual({"": static}, {"a": of_plant, "b": other})) == ["plant.state.y"]
    assert list(_usual({"": static}, {"a": of_plant, "b": {}})) == []


def test_so_are_parameters_that_vary(built_fmus, in_tmp_path, monkeypatch):
    units = iter(["kg", "t", "kg", "t"])

    def variable(path, scenario):
        found = known(path, scenario)
        quantity = replace(found.variable.quantity, unit=next(units))
        return replace(found, variable=replace(found.variable, quantity=quantity))

    known = plan_module._variable
    monkeypatch.setattr(plan_module, "_variable", variable)
    with pytest.raises(RequestError, match=r"Float64 \[kg\] with plant=bicycle, Float64 \[t\] with plant=bicycle_sat"):
        sweep("static", {"plant": "bicycle,bicycle_saturated", "plant.m": "1500:2500"}, samples="lhs:4", options=SHORT)
    assert not Path("runs").exists()


@pytest.fixture(scope="module")
def swept(built_fmus, tmp_path_factory):
    out = tmp_path_factory.mktemp("bands") / "sweep"
    asked = {"samples": "lhs:6", "options": SHORT, "signals": ["plant.motion.a_y", "plant.state.v_x"]}
    return sweep(
        "static", {"plant.m": "1500:2500"}, **asked, out=out, executor=ThreadPoolExecutor(2), keep=["0,1,2,3,4,5"]
    )


def test_they_are_those_of_the_runs(swept):
    folder = Path(swept.attrs["folder"])
    bands = sweep_folder.read_bands(folder)
    runs = [pd.read_parquet(folder / "runs" / f"variant-{n}" / SIGNALS) for n in range(6)]
    for signal, unit in {"plant.motion.a_y": "m/s2", "plant.state.v_x": "m/s"}.items():
        of = bands[bands["signal"] == signal]
        table = np.array([run[signal] for run in runs])
        assert set(of["unit"]) == {unit}
        assert np.array_equal(of["time"], runs[0]["time"])
        assert np.array_equal(of["mean"], table.mean(axis=0))
        assert np.array_equal(of["median"], np.percentile(table, 50, axis=0))


def test_they_stay_when_more_runs_are_kept(swept, tmp_path):
    folder = Path(swept.attrs["folder"])
    before = (folder / sweep_folder.BANDS).read_bytes()
    go_on(folder, lambda: workforce("threads", 1), ["worst:1"], SILENT)
    assert (folder / sweep_folder.BANDS).read_bytes() == before


def test_signals_that_are_not_there_are_refused_before_anything_runs(built_fmus, in_tmp_path):
    options = replace(SHORT, record=("plant.tyre.*:2", "plant.state.*"))
    for signal in ("plant.state.w", "plant.tyre.mu_r"):
        with pytest.raises(RequestError, match="no number that is recorded at every tick") as raised:
            sweep("static", {"plant.m": "1500:2500"}, samples="lhs:6", options=options, signals=[signal])
        assert str(raised.value).startswith(f"--signals {signal}: ")
    assert not Path("runs").exists()
