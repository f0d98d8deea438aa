"""A unit that was closed runs again without being unpacked again, and gives the same numbers."""

from __future__ import annotations

import pytest

from components.interfaces.quantity import Type, zeros
from fmus.reading.opening import open_fmu
from fmus.units import reused_unit as module
from fmus.units.reused_unit import release_all, reused_unit
from fmus.units.unit import UnitError, carry_out, views, widths


@pytest.fixture
def archive(built_fmus):
    yield open_fmu(built_fmus / "fmi3" / "bicycle.fmu")
    release_all()
    assert not any(module._idle.values())


def shown(unit, parameters):
    """The outputs after a few steps."""
    inputs, outputs = (
        {kind: zeros(kind, n) for kind, n in widths(variables).items()}
        for variables in (unit.interface.inputs, unit.interface.outputs)
    )
    unit.bind(inputs, outputs)
    unit.enter_initialization(parameters)
    unit.exit_initialization()
    views(unit.interface.inputs, inputs)["actuation.delta_f"][:] = 0.1
    for tick in range(3):
        carry_out(unit.setters())
        unit.step(0.1 * tick, 0.1)
    carry_out(unit.getters())
    return outputs[Type.FLOAT64].tolist()


def test_a_closed_unit_waits_for_its_next_run_and_begins_anew(archive):
    first = reused_unit("plant", archive)
    expected = shown(first, {"v_x_start": 20.0})
    first.close()
    again = reused_unit("plant", archive)
    assert again is first
    other = reused_unit("other", archive)
    assert other is not first
    other.close()
    assert shown(again, {"v_x_start": 20.0}) == expected
    again.close()


def test_a_unit_whose_reset_fails_is_not_used_again(archive, monkeypatch):
    first = reused_unit("plant", archive)

    def refuse(*_):
        raise UnitError("plant", "the reset failed", ())

    with monkeypatch.context() as patched:
        patched.setattr(first, "_check", refuse)
        first.close()
    second = reused_unit("plant", archive)
    assert second is not first
    second.close()
