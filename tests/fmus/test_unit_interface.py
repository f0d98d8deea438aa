"""A block and the FMUs that are made of it look the same before they run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from components import BLOCKS
from fmus.reading.opening import open_fmu
from fmus.units.block_unit import interface_of


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", ["bicycle", "stanley", "ramp_traffic"])
def test_a_block_and_its_fmus_have_the_same_interface(built_fmus, name, version):
    block = interface_of(BLOCKS[name])
    fmu = open_fmu(built_fmus / f"fmi{version}" / f"{name}.fmu").interface
    for role in ("inputs", "outputs", "parameters"):
        own, read = getattr(block, role), getattr(fmu, role)
        assert [(v.name, v.shape) for v in own] == [(v.name, v.shape) for v in read]
        assert [v.quantity.unit for v in own] == [v.quantity.unit for v in read]
    assert np.array_equal(block.feedthrough, fmu.feedthrough)
    assert block.output_after_set == fmu.output_after_set
    assert block.rolls_back
    assert fmu.rolls_back
    assert not block.event_mode
    assert (fmu.clocks == ()) is (not fmu.event_mode)
    assert fmu.undeclared == frozenset()


def test_outputs_that_follow_through_a_step_only_depend_on_no_input_and_are_known():
    block = replace(interface_of(BLOCKS["stanley"]), undeclared=frozenset({"actuation.delta_f", "actuation.T_r"}))
    assert block.feedthrough.all()
    acting = block.acting_through_step(["actuation.T_r", "of another unit"])
    names = [v.name for v in block.outputs]
    assert acting.feedthrough.any(axis=1).tolist() == [name != "actuation.T_r" for name in names]
    assert acting.undeclared == {"actuation.delta_f"}
    assert block.feedthrough.all()
