"""What controllers are given while they are timed; `test_reproduce` shows the times."""

from __future__ import annotations

import numpy as np

from components.interfaces.quantity import Type
from fmus.units.unit import positions
from orchestrator.reproduction.timing import _recorded_inputs
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate


def test_every_input_of_the_controller_is_what_drove_it_in_the_run():
    scenario = prepare("dynamic", Options(mode="blocks", replacements={"controller": "lqr"}))
    frame = simulate(scenario.system, h=scenario.h, until=1.0)
    rows = _recorded_inputs(scenario.system, frame)
    places = positions(scenario.system.units["controller"].interface.inputs)
    kind, at = places["ego.v_x"]
    assert kind is Type.FLOAT64
    np.testing.assert_array_equal(rows[kind][:, at], frame["plant.state.v_x"])
    for name in ("valid", "id", "x", "width"):
        kind, at = places[f"obstacles.{name}"]
        columns = [f"traffic.obstacles.{name}[{i + 1}]" for i in range(8)]
        np.testing.assert_array_equal(rows[kind][:, at : at + 8], frame[columns].to_numpy())
