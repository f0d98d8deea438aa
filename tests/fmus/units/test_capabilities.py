"""What a unit can do is an object that it has or has not, and its interface says so before it runs."""

from __future__ import annotations

import pytest

from components import BLOCKS
from components.interfaces.quantity import zeros
from fmus.reading.opening import open_fmu
from fmus.units.adaptation import Adaptation, Link
from fmus.units.block_unit import BlockUnit
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.isolated_unit import IsolatedUnit
from fmus.units.make import fmu_unit
from fmus.units.mapped_unit import MappedUnit
from fmus.units.unit import carry_out, views, widths


def opened(how, built_fmus, name):
    """A unit of the block `name`, made in one of the ways that there are."""
    if how == "block":
        return BlockUnit("m", BLOCKS[name])
    archive = open_fmu(built_fmus / ("fmi2" if how == "fmi2" else "fmi3") / f"{name}.fmu")
    if how == "isolated":
        return IsolatedUnit("m", archive)
    unit = fmu_unit("m", archive)
    if how != "mapped":
        return unit
    inputs, outputs = (
        tuple(Link(v.name, tuple((v.name, i) for i in range(v.size))) for v in variables)
        for variables in (unit.interface.inputs, unit.interface.outputs)
    )
    return MappedUnit("m", unit.interface, unit, Adaptation(inputs, outputs))


@pytest.fixture(params=["block", "fmi2", "fmi3", "mapped", "isolated"])
def how(request):
    return request.param


@pytest.mark.parametrize("name", ["bicycle", "stanley"])
def test_a_unit_has_the_capabilities_that_its_interface_tells_of(how, built_fmus, name):
    unit = opened(how, built_fmus, name)
    try:
        assert isinstance(unit.state, StateCapability) is unit.interface.rolls_back is True
        assert isinstance(unit.events, EventCapability) is unit.interface.event_mode
        assert unit.interface.event_mode is (name == "stanley" and how not in ("block", "fmi2"))
    finally:
        unit.close()


@pytest.mark.parametrize("name", ["bicycle", "stanley"])
def test_a_unit_returns_to_a_saved_state_bit_by_bit_as_often_as_it_is_asked(how, built_fmus, name, start_of):
    unit = opened(how, built_fmus, name)
    inputs, outputs = (
        {kind: zeros(kind, n) for kind, n in widths(variables).items()}
        for variables in (unit.interface.inputs, unit.interface.outputs)
    )
    unit.bind(inputs, outputs)
    unit.enter_initialization(start_of(name))
    unit.exit_initialization()
    driven = views(unit.interface.inputs, inputs)

    def stepped(tick):
        driven["actuation.delta_f" if name == "bicycle" else "ego.y"][:] = 0.01 * (tick + 1)
        if name != "bicycle":
            driven["ego.v_x"][:] = 10.0
        assert carry_out(unit.setters()) == 0
        assert not unit.step(0.1 * tick, 0.1)
        assert carry_out(unit.getters()) == 0
        return {kind: column.tolist() for kind, column in outputs.items()}

    stepped(0)
    saved = unit.state.save()
    expected = [stepped(tick) for tick in (1, 2)]
    assert expected[0] != expected[1]
    for _ in range(2):
        unit.state.restore(saved)
        assert [stepped(tick) for tick in (1, 2)] == expected
    unit.state.forget(saved)
    unit.close()
