"""Where signals lie: inputs are views of their drivers where they can be, and what is recorded knows its unit."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.quantity import Type
from fmus.units.unit import carry_out
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.signal_table import RecordedElement, SignalTable
from orchestrator.system.source import block_source
from orchestrator.system.system import System
from tests.orchestrator.blocks import Gain, Held, Sum


@pytest.fixture
def table():
    return SignalTable(prepare("static", Options(mode="blocks")).system)


def small(**held):
    units = {"s": block_source(Sum()), "g": block_source(Gain(k=2.0)), "h": block_source(Held())}
    wiring = {"g.a": "s.b", "h.a": "g.b"}
    return SignalTable(System(units, wiring, held={"s.a.value": 0.5} | held))


def test_inputs_that_lie_side_by_side_are_a_view_and_cost_nothing(table):
    inputs, outputs = table.inputs("controller"), table.outputs("plant")
    assert np.shares_memory(table.inputs("plant")[Type.FLOAT64], table.outputs("controller")[Type.FLOAT64])
    outputs[Type.FLOAT64][:] = np.arange(len(outputs[Type.FLOAT64]))
    carry_out(table.gathers("controller"))
    assert inputs[Type.FLOAT64][:6].tolist() == [0, 1, 2, 3, 4, 5]


def test_an_input_is_held_in_place_of_its_connection_until_it_is_released():
    table = small()
    table.outputs("s")[Type.FLOAT64][:] = 7.0
    assert table.inputs("s")[Type.FLOAT64].tolist() == [0.5]
    assert table.inputs("g")[Type.FLOAT64].tolist() == [7.0]
    table.hold("g", "a.value", 3.0)
    assert table.inputs("g")[Type.FLOAT64].tolist() == [3.0]
    table.release("g", "a.value")
    assert table.inputs("g")[Type.FLOAT64].tolist() == [7.0]
    table.hold("s", "a.value", 4.0)
    table.release("s", "a.value")
    assert table.inputs("s")[Type.FLOAT64].tolist() == [4.0], "nothing else drives it"


def test_elements_are_those_of_the_outputs_in_the_order_of_the_units(table):
    elements = table.elements()
    assert [e.unit for e in elements] == sorted((e.unit for e in elements), key=list(table.system.units).index)
    assert elements[0] == RecordedElement("plant", "plant.state.x", Type.FLOAT64, 0)
    by_path = {e.path: e for e in elements}
    assert len(by_path) == len(elements)
    valid = by_path["traffic.obstacles.valid[3]"]
    table.columns[valid.type][valid.position] = True
    assert table.read("traffic.obstacles.valid").tolist() == [False, False, True, *[False] * 5]
    assert {kind: sum(e.type is kind for e in elements) for kind in Type} == table.recorded
