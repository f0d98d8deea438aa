"""Signals outside the range that their unit declares are told after a run."""

from __future__ import annotations

import json

import numpy as np
import pytest

from orchestrator import Options, load
from orchestrator.results.ranges import out_of_range, range_remarks
from tests.orchestrator.exchange.passport.measured_fmus import lag

T = np.arange(4) * 0.1
ITERATIONS = "controller.solver.iterations"


@pytest.fixture(scope="module")
def system():
    return load("static", Options(mode="blocks")).system


def test_the_first_value_outside_is_told_with_what_is_declared(system):
    found = out_of_range({"time": T, ITERATIONS: np.array([3, 0, -1, -2]), "plant.state.x": -T}, system)
    assert found == {ITERATIONS: {"time": T[2], "value": -1.0, "declared": "0 <= whole number"}}
    (text,) = range_remarks(found)
    assert text == f"`{ITERATIONS}` is -1 at t = 0.2 s, outside of what its unit declares (0 <= whole number)"


@pytest.mark.parametrize("values", [[0, 1, 2, 3], [-1e-12, 0, 0, 0], [np.nan, np.inf, 0, 0]])
def test_inside_and_where_nobody_knows_nothing_is_told(system, values):
    assert out_of_range({"time": T, ITERATIONS: np.array(values, dtype=float)}, system) == {}


def test_the_signals_of_a_unit_are_one_remark():
    facts = {"value": 1.0, "declared": "finite number <= 0"}
    found = {f"plant.{name}": {"time": time, **facts} for time, name in enumerate("dcba")}
    (text,) = range_remarks(found)
    assert text.startswith("`plant.d` is 1 at t = 0 s")
    assert text.endswith("; so are later `plant.c`, `plant.b`, `plant.a`")


def test_a_run_tells_where_an_fmu_of_another_maker_is_not_valid(tmp_path, macrostep):
    lag(tmp_path, u='start="1" unit="V"', y='unit="V" min="-0.1" max="0.5"')
    code, _, err = macrostep("run", "m.fmu", "--step", "0.1", "--stop-time", "2", "--out", "r")
    assert code == 0
    assert "outside of what its unit declares (-0.1 <= finite number <= 0.5 [V])" in " ".join(err.split())
    outside = json.loads((tmp_path / "r" / "summary.json").read_text())["out_of_range"]
    assert outside["fmu.y"]["value"] == pytest.approx(1 - np.exp(-outside["fmu.y"]["time"] / 0.5), rel=0.05)
