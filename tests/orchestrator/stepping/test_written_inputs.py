"""What written inputs received; written while a simulation runs in `test_master.py`."""

from __future__ import annotations

import numpy as np

from orchestrator.stepping.written_inputs import WrittenInputs
from tests.orchestrator.blocks import Gain, Sum, system

TICKS = np.arange(5)
RECORDED = {"sum.b.value": np.array([1.0, 2.0, 3.0, 4.0, 5.0])}


def written():
    return WrittenInputs(system({"gain": Gain(k=2.0), "sum": Sum()}, {"gain.a": "sum.b", "sum.a": "gain.b"}))


def test_between_writing_and_releasing_it_is_the_written_value():
    inputs = written()
    inputs.add(1, "gain.a.value", 9.0)
    inputs.add(3, "gain.a.value", None)
    columns = inputs.columns(RECORDED, TICKS)
    assert list(columns) == ["gain.a.value"]
    assert columns["gain.a.value"].tolist() == [1.0, 9.0, 9.0, 4.0, 5.0]
    assert RECORDED["sum.b.value"].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_where_the_connection_was_not_recorded_there_is_no_column():
    inputs = written()
    inputs.add(1, "sum.a.value", 9.0)
    assert inputs.columns(RECORDED, TICKS) == {}
