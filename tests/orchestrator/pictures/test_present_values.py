"""The values at the time cursor (`present_values.py`)."""

from __future__ import annotations

import numpy as np

from orchestrator.pictures.present_values import shown_signals, tables
from orchestrator.pictures.signals import SignalColumns, signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate


def test_each_row_has_a_table_of_its_values_with_units():
    system = prepare("static", Options(mode="blocks")).system
    frame = simulate(system, h=0.1, until=0.3)
    shown = shown_signals(system, signals(system))
    assert {"delta_f", "T_r", "y", "r", "v_x", "mu_r"} <= {signal.name for signal in shown}
    gap = np.array([np.inf, 3.0, 2.5, 2.0])
    texts = tables(SignalColumns(frame, signals(system)), shown, {"gap": gap})
    assert len(texts) == 4
    lines = texts[3].splitlines()
    assert lines[1] == "|-|-|-|-|"
    rows = [line.split("|") for line in (lines[0], *lines[2:])]
    cells = dict(pair for row in rows for pair in (row[1:3], row[3:5]) if len(pair) == 2)
    assert cells["t"] == "0.30 s"
    assert cells["gap"] == "2 m"
    assert cells["mu_r"] == f"{round(frame['plant.tyre.mu_r'].iloc[3], 3):.3g}"
    assert cells["v_x"] == f"{frame['plant.state.v_x'].iloc[3]:.3g} m/s"
    assert "|gap|-|" in texts[0]


def test_what_was_not_recorded_is_left_out():
    system = prepare("static", Options(mode="blocks")).system
    frame = simulate(system, h=0.1, until=0.1)[["time", "plant.state.y"]]
    texts = tables(SignalColumns(frame, signals(system)), shown_signals(system, signals(system)), {})
    assert texts[0].splitlines() == ["|t|0.00 s|y|0 m|", "|-|-|-|-|"]
