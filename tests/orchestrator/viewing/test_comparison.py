"""Several runs in one recording."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rerun.blueprint.components import LinkAxis
from rerun.chunk import RrdReader

from components.interfaces.problem import RequestError
from orchestrator.pictures.run_picture import MICROSECONDS
from orchestrator.recording.messages import RecordingRequest
from orchestrator.recording.recording import Afterwards
from orchestrator.recording.series_reader import read_series
from orchestrator.results import run_folder as kept
from orchestrator.results.parquet import write_signals
from orchestrator.results.run_folder import write_system
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.viewing import comparison, repair

LINE = arrays(float, 21, elements=st.floats(-1e3, 1e3))


@pytest.fixture(scope="module")
def runs(kept_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    paths = kept_run(folder / "one", until=3.0), kept_run(folder / "two", settings=("controller.b_3=2e-2",), until=2.0)
    return [kept.find(path) for path in paths]


@pytest.fixture(scope="module")
def tables(runs):
    return [pd.read_parquet(run.folder / "signals.parquet") for run in runs]


def _compared(runs, tables, differences, path):
    comparison.compare(runs, [{n: t[n].to_numpy() for n in t} for t in tables], differences, path)
    return read_series(path)


def test_all_runs_and_their_differences_stand_in_one_recording(runs, tables, tmp_path):
    found = _compared(runs, tables, [], tmp_path / "both.rrd")
    for run, table in zip(runs, tables, strict=True):
        ticks, values = found[f"/signals/{run.name}/plant/state/v_x"]
        np.testing.assert_array_equal(ticks, np.arange(len(table)))
        np.testing.assert_array_equal(values[:, 0], table["plant.state.v_x"])
    for column in ("plant.state.y", "plant.state.v_x"):
        ticks, values = found[f"/difference/two/{column}"]
        np.testing.assert_array_equal(ticks, np.arange(21))
        np.testing.assert_array_equal(values[:, 0], tables[1][column] - tables[0][column][:21])
    assert not any(entity.startswith("/difference/one") for entity in found)


def test_a_difference_has_the_colour_of_its_run_as_its_signals_have(runs, tables, tmp_path):
    _compared(runs, tables, [], tmp_path / "both.rrd")
    found = {
        chunk.entity_path: batch.column("SeriesLines:colors").to_pylist()[0]
        for chunk in RrdReader(tmp_path / "both.rrd").stream()
        if "SeriesLines:colors" in (batch := chunk.to_record_batch()).schema.names
    }
    one, two = (found[f"/signals/{name}/plant/state/v_x"] for name in ("one", "two"))
    assert one != two
    assert found["/difference/two/plant.state.y"] == found["/difference/two/plant.state.v_x"] == two


def test_a_chosen_signal_may_be_the_element_of_an_array(runs, tables, tmp_path):
    found = _compared(runs, tables, ["controller.plan.y[3]"], tmp_path / "both.rrd")
    assert [entity for entity in found if entity.startswith("/difference")] == [
        "/difference/two/controller.plan.y\\[3\\]"
    ]


@pytest.fixture(scope="module")
def sparse(tmp_path_factory):
    """A run that records the plant's state at every tick, the plan at every fifth, and nothing else."""
    folder = tmp_path_factory.mktemp("sparse")
    scenario = prepare("static", Options(mode="blocks", record=["plant.state.*", "controller.plan.*:5"]))
    write_system(scenario, folder)
    with Simulation(scenario.system, h=scenario.h, until=1.2, record=scenario.record) as simulation:
        simulation.run()
        write_signals(simulation.columns(), scenario, folder / "signals.parquet")
        recording = Afterwards()
        recording.begin(RecordingRequest(folder, folder / "recording.rrd", simulation.log.elements, {}), simulation)
        recording.end({})
        assert recording.wait() == ""
    return kept.find(folder)


def _in_layout(path, name):
    """The values of a component in the layout that a recording brings along."""
    reader = RrdReader(path)
    (layout,) = reader.blueprints()
    batches = [chunk.to_record_batch() for chunk in reader.stream(store=layout)]
    return [value for b in batches if name in b.schema.names for (value,) in b.column(name).to_pylist()]


def _views(path):
    """The names of all views."""
    return set(_in_layout(path, "ViewBlueprint:display_name"))


def test_all_plots_show_the_same_seconds(sparse):
    kinds = _in_layout(sparse.recording, "ViewBlueprint:class_identifier")
    links = _in_layout(sparse.recording, "TimeAxis:link")
    assert links == [LinkAxis.LinkToGlobal.value] * kinds.count("TimeSeries")
    assert links


def test_a_recordings_layout_has_the_views_of_what_is_recorded(sparse, tmp_path):
    seen = {
        "Bird's eye view: x to the right, y up",
        "Following view",
        "y [m]",
        "r [rad/s]",
        "v_x [m/s]",
        "Values at the time cursor",
        "Events",
        "plant.state [m]: x blue, y orange",
        "plant.state.psi [rad]",
        "plant.state [m/s]",
        "plant.state.r [rad/s]",
        "controller.plan [m]",
        "About this run",
    }
    assert _views(sparse.recording) == seen | {f"Wall time [{MICROSECONDS}] per step"}
    comparison.rebuild(sparse, repair.rows(sparse, tmp_path, print), tmp_path / "anew.rrd")
    assert _views(tmp_path / "anew.rrd") == seen


def test_trails_show_the_past_all_of_it_on_the_road_and_two_seconds_of_friction(runs):
    reader = RrdReader(runs[0].recording)
    (layout,) = reader.blueprints()
    found = [
        (chunk.entity_path.partition("/overrides")[2], ranges[0]["range"])
        for chunk in reader.stream(store=layout)
        if "VisibleTimeRanges:ranges" in (batch := chunk.to_record_batch()).schema.names
        for ranges in batch.column("VisibleTimeRanges:ranges").to_pylist()
    ]
    whole, short = ({"start": start, "end": 0} for start in (None, -2_000_000_000))
    trails = [(entity.removesuffix("/visualizers"), range_) for entity, range_ in found]
    assert sorted(trails, key=str) == [("/friction/past", short), ("/world/trail", whole), ("/world/trail", whole)]


def test_a_run_made_anew_has_each_signal_at_its_own_ticks(sparse, tmp_path):
    comparison.rebuild(sparse, repair.rows(sparse, tmp_path, print), tmp_path / "anew.rrd")
    found, expected = read_series(tmp_path / "anew.rrd"), read_series(sparse.recording)
    assert expected.keys() - found.keys() == {"/performance/step_time"}
    assert found["/signals/controller/plan/x"][0].tolist() == [0, 5, 10]
    for entity, (ticks, values) in found.items():
        np.testing.assert_array_equal(ticks, expected[entity][0], entity)
        np.testing.assert_array_equal(values, expected[entity][1], entity)


def _log(path):
    lines = []
    for chunk in RrdReader(path).stream():
        if chunk.entity_path.startswith("/events"):
            batch = chunk.to_record_batch()
            lines += zip(batch.column("tick").to_pylist(), batch.column("TextLog:text").to_pylist(), strict=True)
    return lines


def test_why_a_run_ended_before_its_time_is_told_at_its_last_tick(kept_run, runs, tables, tmp_path):
    folder = kept_run(tmp_path / "broken", until=1.0)
    fault = {"tick": 10, "time": 1.0, "unit": "plant", "reason": "it is gone"}
    told = {"scenario": "s", "title": "t", "status": "fault", "units": {}, "versions": {}, "fault": fault}
    (folder / "summary.json").write_text(json.dumps(told))
    broken = kept.find(folder)
    table = repair.rows(broken, tmp_path, print)
    comparison.rebuild(broken, table, tmp_path / "anew.rrd")
    told = [(10, ["fault in unit `plant`: it is gone"])]
    assert [line for line in _log(tmp_path / "anew.rrd") if line in told] == told
    comparison.compare([runs[0], broken], [tables[0], table], [], tmp_path / "both.rrd")
    assert [line for line in _log(tmp_path / "both.rrd") if "fault" in line[1][0]] == [
        (10, ["broken: fault in unit `plant`: it"])
    ]


def test_in_a_comparison_each_signal_has_its_own_ticks(runs, tables, sparse, tmp_path):
    both = [runs[0], sparse], [tables[0], pd.read_parquet(sparse.folder / "signals.parquet")]
    found = _compared(*both, [], tmp_path / "both.rrd")
    assert found[f"/signals/{runs[0].name}/controller/plan/x"][0].tolist() == list(range(31))
    assert found[f"/signals/{sparse.name}/controller/plan/x"][0].tolist() == [0, 5, 10]
    assert found[f"/difference/{sparse.name}/plant.state.y"][0].tolist() == list(range(13))
    assert f"/derived/{sparse.name}/path_error" not in found


@given(first=LINE, other=LINE)
def test_a_difference_is_zero_from_itself_and_turns_with_the_order(first, other):
    t = np.arange(21) * 0.1
    a, b = {"time": t, "x": first}, {"time": t, "x": other}
    assert not comparison.difference(a, a, "x").any()
    np.testing.assert_array_equal(comparison.difference(a, b, "x"), -comparison.difference(b, a, "x"))


def test_runs_of_other_steps_are_aligned_by_time():
    coarse = {"time": np.arange(5) * 0.2, "x": np.arange(5) * 2.0}
    fine = {"time": np.arange(12) * 0.1, "x": np.arange(12) * 1.0 + 3}
    np.testing.assert_allclose(comparison.difference(coarse, fine, "x"), [3] * 9 + [np.nan] * 3)


def test_a_signal_that_was_recorded_now_and_then_has_a_difference_all_the_same():
    rare = {"time": np.arange(7) * 0.1, "x": np.array([0, np.nan, np.nan, 3, np.nan, np.nan, 6.0])}
    dense = {"time": np.arange(9) * 0.1, "x": np.arange(9) + 2.0}
    np.testing.assert_allclose(comparison.difference(rare, dense, "x"), [2] * 7 + [np.nan] * 2)
    np.testing.assert_allclose(comparison.difference(dense, rare, "x"), [-2, *[np.nan] * 2] * 2 + [-2])
    never = {"time": rare["time"], "x": np.full(7, np.nan)}
    assert np.isnan(comparison.difference(never, dense, "x")).all()


def test_a_signal_that_is_not_there_is_refused_for_every_run(runs, tables, tmp_path):
    with pytest.raises(RequestError) as raised:
        _compared(runs, tables, ["plant.state.w"], tmp_path / "both.rrd")
    valid = "valid: a recorded signal, such as plant.state.y. Did you mean `plant.state.y`?"
    assert [str(p) for p in raised.value.problems] == [
        f"--difference plant.state.w: found no such signal in {run.where}; {valid}" for run in runs
    ]


def test_an_array_is_asked_for_by_its_elements(runs, tables, tmp_path):
    with pytest.raises(RequestError) as raised:
        _compared(runs[:1], tables[:1], ["traffic.obstacles.x"], tmp_path / "both.rrd")
    assert str(raised.value) == (
        f"--difference traffic.obstacles.x: found no such signal in {runs[0].where}; "
        "valid: a recorded signal, such as plant.state.y. Did you mean `traffic.obstacles.x[1]`?"
    )


def test_a_run_that_recorded_nothing_has_no_differences(runs, tables, tmp_path):
    with pytest.raises(RequestError) as raised:
        _compared(runs[:1], [tables[0][["time"]]], ["plant.state.y"], tmp_path / "both.rrd")
    found = f"--difference plant.state.y: found no such signal in {runs[0].where}"
    assert str(raised.value) == f"{found}; valid: a run that recorded it"


def test_runs_of_the_same_name_are_told_apart_by_their_folders(kept_run, tmp_path):
    paths = [kept_run(tmp_path / part / "static-1", until=0.5) for part in "ab"]
    found = [kept.find(path) for path in paths]
    series = _compared(found, [pd.read_parquet(p / "signals.parquet") for p in paths], [], tmp_path / "both.rrd")
    names = {comparison.entity("difference", str(path), "plant.state.y") for path in paths[1:]}
    assert names <= series.keys()
