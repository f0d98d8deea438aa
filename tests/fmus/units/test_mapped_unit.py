"""A unit behind a mapping: an echo that is given values in its own terms gives them back in ours.

What `fmus/units/adaptation.py` can say, and what `rates.py` does, is shown here, too.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.buses import ObstacleList, VehicleState
from components.interfaces.conversion import Linear
from components.interfaces.maths import Array
from components.interfaces.quantity import Type, quantity, zeros
from components.interfaces.record import record, variables
from components.interfaces.sockets import ControllerInputs
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, Link, RateInput
from fmus.units.block_unit import BlockUnit
from fmus.units.conventions import BoxEnd, ReferencePoint, RoadFrameVelocity
from fmus.units.mapped_unit import MappedUnit
from fmus.units.unit import widths
from tests.fmus.units.echo import echo

OURS = variables(ControllerInputs)


@record
class Numbers:
    """Numbers of all kinds, as a tool without types has them."""

    ego: Array = quantity("1", "numbers", shape=(6,))
    boxes: Array = quantity("1", "numbers", shape=(64,))


Echo = echo(Numbers)


def links(end, relation):
    """Every signal of ours and where in the echo's numbers it is."""
    found = []
    for i, variable in enumerate(OURS):
        mine = relation if variable.quantity.type.is_float else Linear()
        bus, first = ("ego", i) if i < 6 else ("boxes", 8 * (i - 6))
        found.append(Link(variable.name, tuple((f"{end}.{bus}", first + j) for j in range(variable.size)), mine))
    return tuple(found)


def interface(outputs=OURS, inputs=OURS):
    through = np.ones((len(outputs), len(inputs)), dtype=bool)
    return Interface("echo", inputs, outputs, (), through, output_after_set=True, starts={})


def columns(variables_):
    return {kind: zeros(kind, n) for kind, n in widths(variables_).items()}


def mapped(adaptation, ours=None):
    unit = MappedUnit("echo", ours or interface(), BlockUnit("echo", Echo), adaptation)
    inputs, outputs = columns(unit.interface.inputs), columns(unit.interface.outputs)
    unit.bind(inputs, outputs)
    unit.enter_initialization({})
    unit.exit_initialization()
    return unit, inputs, outputs


def run(operations):
    for operation in operations:
        operation()


@given(
    factor=st.floats(0.01, 100) | st.floats(-100, -0.01),
    offset=st.floats(-100, 100),
    ahead=st.floats(-4, 4),
    share=st.sampled_from([-0.5, 0.5]),
    seed=st.integers(0, 2**16),
)
def test_there_and_back_is_the_identity(factor, offset, ahead, share, seed):
    relation = Linear(factor, offset)
    conventions = {"ego": (RoadFrameVelocity(), ReferencePoint(ahead)), "obstacles": (BoxEnd(share),)}
    unit, inputs, outputs = mapped(Adaptation(links("u", relation), links("y", relation), conventions=conventions))
    draw = np.random.default_rng(seed)
    inputs[Type.FLOAT64][:] = draw.uniform(-50, 50, inputs[Type.FLOAT64].size)
    inputs[Type.BOOLEAN][:] = draw.integers(0, 2, 8)
    inputs[Type.INT32][:] = draw.integers(-9, 9, 8)
    given_ = {kind: column.copy() for kind, column in inputs.items()}
    run([*unit.setters(), *unit.getters()])
    for kind, column in given_.items():
        assert inputs[kind].tolist() == column.tolist(), "inputs belong to the master"
        assert outputs[kind] == pytest.approx(column, abs=1e-6)


def test_numbers_that_keep_their_unit_keep_every_bit():
    unit, inputs, outputs = mapped(Adaptation(links("u", Linear()), links("y", Linear())))
    inputs[Type.FLOAT64][:] = np.random.default_rng(1).normal(size=inputs[Type.FLOAT64].size)
    run([*unit.setters(), *unit.getters()])
    assert outputs[Type.FLOAT64].tolist() == inputs[Type.FLOAT64].tolist()


def test_what_nothing_drives_keeps_its_start_and_limits_hold():
    held = Adaptation(
        inputs=(Link("ego.x", (("u.ego", 0),), low=-1.0, high=2.0),),
        outputs=(Link("ego.x", (("y.ego", 0),)), Link("ego.y", (("y.ego", 1),))),
        constants={"ego.r": 0.25},
        held={"u.ego": [0.0, 7.0, 0.0, 0.0, 0.0, 0.0]},
    )
    shown = tuple(v for v in OURS if v.name in {"ego.x", "ego.y", "ego.r"})
    unit, inputs, outputs = mapped(held, interface(shown, OURS[:1]))
    for given_, wanted in ((1.5, 1.5), (9.0, 2.0), (-9.0, -1.0)):
        inputs[Type.FLOAT64][0] = given_
        run([*unit.setters(), *unit.getters()])
        assert outputs[Type.FLOAT64].tolist() == [wanted, 7.0, 0.25]


def rates(limit=np.inf, *, shown):
    present = Link("ego.psi", (("y.ego", 1),)) if shown else None
    rate = RateInput(Link("ego.psi", (("u.ego", 0),), Linear(0.5)), present, limit)
    psi = tuple(v for v in OURS if v.name == "ego.psi")
    adaptation = Adaptation(
        outputs=(Link("ego.psi", (("y.ego", 0),)),), rates=(rate,), held={"u.ego": [0.0, 0.2, 0.0, 0.0, 0.0, 0.0]}
    )
    return mapped(adaptation, interface(psi, psi))


def test_a_rate_leads_to_the_signal_within_the_step():
    unit, inputs, outputs = rates(shown=False)
    found = []
    for wanted in (0.3, 0.3, 0.1):
        inputs[Type.FLOAT64][0] = wanted
        run(unit.setters())
        assert not unit.step(0.0, 0.1)
        run(unit.getters())
        found.append(outputs[Type.FLOAT64][0])
    assert found == pytest.approx([6.0, 0.0, -4.0])  # twice 0.3 / 0.1, as half a unit of theirs is one of ours


@pytest.mark.parametrize("shown", [False, True])
def test_after_a_reset_rates_and_held_values_begin_anew(shown):
    unit, inputs, outputs = rates(shown=shown)

    def stepped():
        found = []
        for wanted in (0.3, 0.4):
            inputs[Type.FLOAT64][0] = wanted
            run([*unit.setters(), *unit.getters()])
            unit.step(0.0, 0.1)
            run(unit.getters())
            found.append(outputs[Type.FLOAT64][0])
        return found

    first = stepped()
    unit.messages.append("a message")
    unit.warned()
    unit.reset()
    assert (len(unit.messages), unit.warnings) == (0, 0)
    unit.bind(inputs, outputs)
    unit.enter_initialization({})
    unit.exit_initialization()
    assert stepped() == first


def test_the_rate_starts_from_the_value_that_the_unit_shows_and_is_limited():
    unit, inputs, outputs = rates(limit=2.0, shown=True)
    inputs[Type.FLOAT64][0] = 0.3
    run([*unit.setters(), *unit.getters()])
    unit.step(0.0, 0.1)
    run(unit.getters())
    assert outputs[Type.FLOAT64][0] == pytest.approx(2.0 * (0.3 - 0.2) / 0.1)
    inputs[Type.FLOAT64][0] = 9.0
    run(unit.setters())
    unit.step(0.1, 0.1)
    run(unit.getters())
    assert outputs[Type.FLOAT64][0] == pytest.approx(2.0 * 2.0)


def test_an_output_that_is_a_rate_is_integrated():
    psi = tuple(v for v in OURS if v.name == "ego.psi")
    adaptation = Adaptation(
        (Link("ego.psi", (("u.ego", 0),)),), (Link("ego.psi", (("y.ego", 0),)),), integrated=("ego.psi",)
    )
    unit, inputs, outputs = mapped(adaptation, interface(psi, psi))
    found = []
    for rate in (1.0, 1.0, -3.0):
        inputs[Type.FLOAT64][0] = rate
        run(unit.setters())
        unit.step(0.0, 0.1)
        run([*unit.getters(), *unit.getters()])
        found.append(outputs[Type.FLOAT64][0])
    assert found == pytest.approx([0.1, 0.2, -0.1])


def test_records_of_the_test_are_those_of_the_buses():
    assert len(OURS) == len(variables(VehicleState)) + len(variables(ObstacleList))
