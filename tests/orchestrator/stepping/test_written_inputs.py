"""What inputs that were written received; written in a running simulation they are in `test_master`."""

from __future__ import annotations

import numpy as np

from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.written_inputs import WrittenInputs
from orchestrator.system.source import block_source
from orchestrator.system.system import System
from tests.orchestrator.blocks import Gain, Sum

TICKS = np.arange(5)


def test_an_array_is_received_element_by_element_from_where_it_comes():
    written = WrittenInputs(prepare("static", Options(mode="blocks")).system)
    shown = {f"traffic.obstacles.x[{i}]": np.full(5, 10.0 * i) for i in range(1, 9)}
    assert written.received(shown, TICKS) == {}
    written.note(2, "controller.obstacles.x", [0.5] * 8)
    written.note(4, "controller.obstacles.x", None)
    received = written.received(shown, TICKS)
    assert list(received) == [f"controller.obstacles.x[{i}]" for i in range(1, 9)]
    for i in range(1, 9):
        assert received[f"controller.obstacles.x[{i}]"].tolist() == [10.0 * i, 10.0 * i, 0.5, 0.5, 10.0 * i]


def test_what_was_not_recorded_is_left_out_and_what_nothing_drives_keeps_its_value():
    system = System({"s": block_source(Sum()), "g": block_source(Gain(k=2.0))}, {"g.a": "s.b"}, held={"s.a.value": 0.5})
    written = WrittenInputs(system)
    written.note(1, "g.a.value", 3.0)
    written.note(3, "s.a.value", 4.0)
    received = written.received({}, TICKS)
    assert {path: values.tolist() for path, values in received.items()} == {"s.a.value": [0.5, 0.5, 0.5, 4.0, 4.0]}
