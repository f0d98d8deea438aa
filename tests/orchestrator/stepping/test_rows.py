"""The rows of a run: what is kept at which ticks (`paces.py`, `row_group.py`), and in which pieces (`row_batch.py`)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.problem import RequestError
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping import rows
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import EVERYTHING


@cache
def static():
    return prepare("static", Options(mode="blocks", stop_time=2.0))


def simulated(choice=EVERYTHING):
    made = static()
    with Simulation(made.system, h=made.h, until=made.until, record=choice) as simulation:
        simulation.run()
        return simulation


@pytest.fixture(scope="module")
def whole():
    """All rows of all signals."""
    return simulated().frame()


def test_without_a_choice_everything_is_kept_at_every_tick(whole):
    assert len(whole) == 21
    assert {"plant.state.x", "traffic.obstacles.valid[8]", "controller.solver.status"} <= set(whole)
    assert whole["traffic.obstacles.valid[1]"].dtype == np.bool_
    assert whole["controller.solver.status"].dtype == np.int64


def test_what_no_pattern_fits_is_not_kept(whole):
    frame = simulated({"plant.state.*": 1, "controller.actuation.delta_f": 1}).frame()
    expected = ["time", *(f"plant.state.{s}" for s in ("x", "y", "psi", "v_x", "v_y", "r"))]
    assert list(frame) == [*expected, "controller.actuation.delta_f"]
    assert frame.equals(whole[list(frame)])


def test_places_that_do_not_lie_side_by_side_are_picked(whole):
    names = ["plant.state.y", "plant.state.r", "traffic.obstacles.id", "controller.solver.iterations"]
    frame = simulated(dict.fromkeys(names, 1)).frame()
    assert frame.equals(whole[list(frame)])
    assert len(frame.columns) == 1 + 2 + 8 + 1


def test_the_last_pattern_that_fits_counts_and_0_is_never(whole):
    frame = simulated({"*": 1, "controller.*": 0, "controller.solver.*": 1}).frame()
    assert {name.rpartition(".")[0] for name in frame if name.startswith("controller")} == {"controller.solver"}
    assert frame.equals(whole[list(frame)])


def test_signals_that_are_kept_more_rarely_are_empty_in_between(whole):
    frame = simulated({"plant.state.*": 1, "controller.*": 5}).frame()
    assert frame["plant.state.x"].equals(whole["plant.state.x"])
    status = frame["controller.solver.status"]
    assert status.notna().tolist() == [k % 5 == 0 for k in range(21)]
    assert status[::5].tolist() == whole["controller.solver.status"][::5].tolist()


def test_rows_are_those_ticks_at_which_something_was_kept(whole):
    frame = simulated({"plant.state.*": 4, "controller.*": 6}).frame()
    assert np.rint(frame["time"] / 0.1).tolist() == [0, 4, 6, 8, 12, 16, 18, 20]
    assert frame["plant.state.x"].dropna().tolist() == whole["plant.state.x"][::4].tolist()


def test_a_run_that_records_nothing_still_has_its_ticks(whole):
    assert simulated({"*": 0}).frame().equals(whole[["time"]])


def test_patterns_that_only_leave_out_leave_the_rest(whole):
    frame = simulated({"plant.*": 0, "controller.plan.*": 0}).frame()
    left = [name for name in whole if not name.startswith(("plant.", "controller.plan."))]
    assert frame.equals(whole[left])


@pytest.mark.parametrize("every", [2**31, 2**63, 10**30])
def test_a_pace_beyond_the_end_keeps_the_first_row(whole, every):
    frame = simulated({"plant.*": every}).frame()
    assert frame["time"].tolist() == [0]
    assert frame["plant.state.x"].tolist() == whole["plant.state.x"][:1].tolist()


def test_a_pattern_that_fits_nothing_is_refused():
    with pytest.raises(RequestError) as error:
        simulated({"plant.state.*": 1, "plant.stat.x": 1, "driver.*": 2})
    first, second = str(error.value).splitlines()
    assert first.startswith("record plant.stat.x: found a pattern that no signal fits; valid: ")
    assert first.endswith("Did you mean `plant.state.x`?")
    assert second.startswith("record driver.*: found a pattern that no signal fits; valid: ")


@pytest.mark.parametrize("part", ["plant", "plant.state"])
def test_a_unit_or_a_bus_is_a_pattern_with_a_star(part):
    with pytest.raises(RequestError) as error:
        simulated({part: 1})
    assert str(error.value).startswith(f"record {part}: found a pattern that no signal fits; valid: ")
    assert str(error.value).endswith(f"Did you mean `{part}.*`?")


def test_what_is_not_recorded_takes_no_memory(monkeypatch):
    monkeypatch.setattr(rows, "LARGEST_LOG", 10_000)
    with pytest.raises(
        RequestError, match=r"stop time: found 21 ticks, .* GiB of rows; valid: at most .* less to record"
    ):
        simulated()
    assert len(simulated({"plant.*": 1}).frame()) == 21


@given(
    cuts=st.lists(st.integers(0, 21), max_size=5).map(sorted),
    choice=st.sampled_from([EVERYTHING, {"plant.*": 1, "controller.*": 5}, {"plant.*": 3, "traffic.*": 2}]),
)
def test_batches_hold_every_row_once(cuts, choice):
    simulation = simulated(choice)
    frame = simulation.frame().set_index("time")
    found = {name: [] for name in frame}
    times = []
    for first, last in zip([0, *cuts], [*cuts, 21], strict=True):
        for batch in simulation.log.batches(first, last, simulation.step_times):
            assert (batch.step_times == simulation.step_times[batch.ticks]).all()
            columns = batch.columns(simulation.log.elements[batch.group])
            assert columns.pop("time").tolist() == (batch.ticks * 0.1).tolist()
            times += batch.ticks.tolist() if batch.group == 0 else []
            for name, values in columns.items():
                assert len(values) == len(batch)
                found[name] += values.tolist()
    assert times == list(range(0, 21, min(n for n in choice.values())))
    for name, values in found.items():
        assert values == frame[name].dropna().tolist(), name
