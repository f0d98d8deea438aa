"""The events of a run, told once each, at their tick, however the rows come in batches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.pictures import drawing, events, plots
from orchestrator.pictures.signals import SignalColumns, signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.system.shown import shown

STATIC = prepare("static", Options(mode="blocks"))
BUSES = shown(STATIC.system)
SIGNALS = signals(STATIC.system)


@pytest.fixture(scope="module")
def frame():
    with Simulation(STATIC.system, h=0.1, until=11.3) as simulation:
        simulation.run()
        return simulation.frame()


def _told(frame, batches=1):
    """(row of the run, level, text) of all events."""
    log = events.EventLog(BUSES, STATIC.scene, plots.limits(STATIC.system, SIGNALS))
    found, first = [], 0
    for rows in np.array_split(np.arange(len(frame)), batches):
        columns = SignalColumns(frame.iloc[rows], SIGNALS)
        boxes, _ = drawing.obstacles(columns, BUSES)
        near = drawing.nearest(columns, BUSES, STATIC.scene, boxes)
        found += [(first + event.row, event.level, event.text) for event in log.of(columns, near)]
        first += len(rows)
    return found


def test_the_lane_change_is_told_where_it_begins_and_ends(frame):
    told = [(row, text.partition(" at ")[0]) for row, _, text in _told(frame) if " at x = " in text]
    assert [text for _, text in told] == [
        "lane change begun",
        "lane change finished",
        "return begun",
        "return finished",
    ]
    for (row, _), i in zip(told, (1, 7, 8, 11), strict=True):
        at = frame[f"controller.path.x[{i + 1}]"]
        assert frame["plant.state.x"][row - 1] < at[row] <= frame["plant.state.x"][row]


def test_a_change_to_the_third_lane_is_told_as_one():
    made = prepare("three-lanes", Options(mode="blocks"))
    with Simulation(made.system, h=0.1, until=9.0) as simulation:
        simulation.run()
        columns = SignalColumns(simulation.frame(), signals(made.system))
    phase = events.phases(columns, shown(made.system), made.scene)
    names = [events.PHASES[i] for i in phase]
    assert [n for i, n in enumerate(names) if i == 0 or names[i - 1] != n] == [
        "own lane",
        "changing out",
        "third lane",
        "changing back",
        "own lane",
    ]
    log = events.EventLog(shown(made.system), made.scene, [])
    told = [event.text.partition(" at ")[0] for event in log.of(columns, None) if " at x = " in event.text]
    assert told[1] == "lane change to the third lane finished"


def test_a_limit_is_told_once_per_stretch_also_where_it_is_left_for_a_moment(frame):
    rows = np.flatnonzero(frame["controller.actuation.T_r"] >= 200)
    begins = [row for row, before in zip(rows, [-100, *rows[:-1]], strict=True) if row - before > 10]
    assert 1 < len(begins) < len([row for row in rows if row - 1 not in rows])
    told = [row for row, level, text in _told(frame) if text == "limit active: T_r at 200 N.m" and level == "WARN"]
    assert told == begins


@settings(max_examples=20, deadline=None)
@given(batches=st.integers(1, 114))
def test_batches_tell_the_same_as_the_whole(frame, batches):
    assert _told(frame, batches) == _told(frame)


def test_a_fallback_a_near_miss_and_a_contact_are_told(frame):
    frame = frame.head(20).copy()
    frame["controller.solver.status"] = [1] * 5 + [3] * 5 + [2] * 2 + [1] * 8
    length = STATIC.scene.ego_length
    frame["traffic.obstacles.x[1]"] = frame["plant.state.x"] + length + 5.0
    frame["traffic.obstacles.length[1]"] = length
    frame.loc[12:14, "traffic.obstacles.x[1]"] -= 5.0 - 0.2
    frame.loc[15, "traffic.obstacles.x[1]"] -= 5.5
    assert [(row, level, text) for row, level, text in _told(frame) if not text.startswith("lane")] == [
        (5, "ERROR", "solver: fallback, the previous plan is followed"),
        (10, "WARN", "solver: iteration limit, not converged"),
        (12, "WARN", "near miss: 0.20 m to #1"),
        (15, "ERROR", "contact with #1"),
    ]


def test_of_several_obstacles_the_nearest_is_told(frame):
    frame = frame.head(1).copy()
    length = STATIC.scene.ego_length
    for slot, gap in ((1, 0.3), (2, 0.1), (3, 0.2)):
        frame[f"traffic.obstacles.x[{slot}]"] = frame["plant.state.x"] + length + gap
        frame[f"traffic.obstacles.y[{slot}]"] = frame["plant.state.y"]
        frame[f"traffic.obstacles.length[{slot}]"] = length
    assert _told(frame) == [(0, "WARN", "near miss: 0.10 m to #2")]


def test_leaving_the_road_is_told(frame):
    frame = frame.head(4).copy()
    frame.loc[2:, "plant.state.y"] = STATIC.scene.y_right
    frame["plant.state.psi"] = 0.0
    told = [event for event in _told(frame) if event[2].startswith("off")]
    assert told == [(2, "ERROR", f"off the road by {STATIC.scene.ego_width / 2:.2f} m")]


def test_a_plan_that_moves_is_told_once_per_second(frame):
    frame = frame.head(30).copy()
    frame["controller.path.x[9]"] = 60.0
    frame.loc[10:, "controller.path.x[9]"] += 5.0
    frame.loc[20:, "controller.path.x[9]"] += np.arange(10) * 2.0
    rows = [row for row, _, text in _told(frame) if text.startswith("replanned")]
    assert rows == [10, 21]
    assert "replanned: lane change from x = 20.0 m, return from x = 65.0 m" in [text for *_, text in _told(frame)]


def test_without_a_path_there_is_no_manoeuvre():
    idle = prepare("idle", Options(mode="blocks"))
    columns = SignalColumns({"time": np.zeros(1)}, signals(idle.system))
    assert events.phases(columns, shown(idle.system), idle.scene) is None
    log = events.EventLog(shown(idle.system), idle.scene, [])
    assert log.of(columns, None) == []
