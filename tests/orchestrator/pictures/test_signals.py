"""The signals of a system, and which of them are recorded."""

from __future__ import annotations

import pandas as pd
import pytest

from components.interfaces.buses import VehicleState
from orchestrator.pictures import drawing
from orchestrator.pictures.signals import PATH_SIGNALS, Recorded, SignalColumns, signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.shown import shown


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


def test_what_was_not_recorded_is_not_there(static):
    columns = SignalColumns(pd.DataFrame({"time": [0.0], "plant.state.x": [1.0]}), signals(static.system))
    assert [s.path for s in columns.signals] == ["plant.state.x"]
    assert columns.bus(shown(static.system), VehicleState, "x", "y") is None
    assert columns.bus({}, VehicleState, "x") is None
    assert drawing.obstacles(columns, shown(static.system)) is None
    assert drawing.path_errors(columns, shown(static.system)) is None


def test_only_what_is_recorded_at_the_same_ticks_meets_in_a_picture(static):
    buses = shown(static.system)
    assert drawing.has_path_errors(Recorded(static.system), buses)
    path = [f"controller.path.{name}[{i + 1}]" for name in "xy" for i in range(15)]
    place = ["plant.state.x", "plant.state.y"]
    assert drawing.has_path_errors(Recorded(static.system, [[*path, *place]]), buses)
    apart = Recorded(static.system, [path, place])
    assert [signal.path for signal in apart.signals] == [
        "plant.state.x",
        "plant.state.y",
        "controller.path.x",
        "controller.path.y",
    ]
    assert apart.bus(buses, VehicleState, "x", "y")
    assert not drawing.has_path_errors(apart, buses)
    assert not Recorded(static.system, [path[:-1]]).bus(buses, *PATH_SIGNALS)
