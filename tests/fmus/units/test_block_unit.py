"""A block as a unit; whole systems of them run in `tests/orchestrator/stepping` and `tests/closed_loop`."""

from __future__ import annotations

import numpy as np
import pytest

from components import BLOCKS
from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type, zeros
from fmus.units.block_unit import BlockUnit, interface_of, substeps
from fmus.units.unit import UnitError, carry_out, widths


@pytest.mark.parametrize(
    ("h", "max_step", "n"), [(0.1, 0.1, 1), (0.1, 0.02, 5), (0.3, 0.1, 3), (0.31, 0.1, 4), (0.1, np.inf, 1)]
)
def test_a_macro_step_is_divided_into_equal_parts_that_are_short_enough(h, max_step, n):
    assert substeps(h, max_step) == n


def test_feedthrough_is_told_variable_by_variable():
    plant = interface_of(BLOCKS["bicycle"])
    rows = {v.name: i for i, v in enumerate(plant.outputs)}
    columns = {v.name: i for i, v in enumerate(plant.inputs)}
    assert plant.feedthrough.shape == (len(rows), len(columns))
    assert plant.feedthrough[rows["tyre.alpha_f"], columns["actuation.delta_f"]]
    assert not plant.feedthrough[rows["state.x"]].any()


def test_missing_values_and_a_state_that_is_not_finite_are_refused(start_of):
    unit = BlockUnit("m", BLOCKS["bicycle"])
    with pytest.raises((RequestError, TypeError)):
        unit.enter_initialization({"m": 1.0})
    unit.enter_initialization(start_of("bicycle"))
    unit._memory.x[0] = np.nan
    with pytest.raises(UnitError, match="m: its initial state is not finite"):
        unit.exit_initialization()


def test_a_sampled_block_shows_its_last_sample_until_the_next(start_of):
    unit = BlockUnit("m", BLOCKS["stanley"])
    inputs, outputs = (
        {kind: zeros(kind, n) for kind, n in widths(variables).items()}
        for variables in (unit.interface.inputs, unit.interface.outputs)
    )
    unit.bind(inputs, outputs)
    unit.enter_initialization(start_of("stanley"))
    unit.exit_initialization()

    def shown(value):
        inputs[Type.FLOAT64][:] = value
        carry_out(unit.setters())
        carry_out(unit.getters())
        return outputs[Type.FLOAT64].tolist()

    assert shown(1.0) != shown(2.0), "before the first sample it shows what it would sample now"
    unit.step(0.0, 0.1)
    assert shown(3.0) == shown(4.0)
