"""The blocks beside a foreign unit do what `MappedUnit` does around it, here compared with it step by step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from components.interfaces.buses import ObstacleList, VehicleState
from components.interfaces.conversion import Linear
from components.interfaces.maths import Array
from components.interfaces.quantity import Quantity, quantity, zeros
from components.interfaces.record import Variable, record, variables
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation, Link, RateInput
from fmus.units.block_unit import BlockUnit, interface_of
from fmus.units.conventions import BoxEnd, ReferencePoint, RoadFrameVelocity, SpeedAndSlip
from fmus.units.mapped_unit import MappedUnit
from fmus.units.unit import carry_out, positions, widths
from orchestrator.mapping.adapter_block import Part, input_adapter, output_adapter
from tests.fmus.units.echo import echo

H = 0.1
OURS = (*variables(VehicleState, prefix="state."), *variables(ObstacleList, prefix="obstacles."))


@record
class Numbers:
    """Numbers as a tool without types has them."""

    n: Array = quantity("1", "numbers", shape=(70,))


Echo = echo(Numbers)


THEIRS = interface_of(Echo)


def columns(signals):
    return {kind: zeros(kind, n) for kind, n in widths(signals).items()}


class Run:
    """A unit with memory, whose signals are set and read by name."""

    def __init__(self, unit):
        self.unit = unit
        self.inputs, self.outputs = columns(unit.interface.inputs), columns(unit.interface.outputs)
        unit.bind(self.inputs, self.outputs)
        unit.enter_initialization({})
        unit.exit_initialization()

    def slot(self, name):
        ours = self.unit.interface
        signals, memory = (
            (ours.inputs, self.inputs) if name in {v.name for v in ours.inputs} else (ours.outputs, self.outputs)
        )
        kind, at = positions(signals)[name]
        size = next(v.size for v in signals if v.name == name)
        return memory[kind][at : at + size]

    def step(self):
        carry_out(self.unit.setters())
        self.unit.step(0.0, H)
        carry_out(self.unit.getters())


def mapped(adaptation, inputs=(), outputs=()):
    through = np.ones((len(outputs), len(inputs)), dtype=bool)
    ours = Interface("echo", inputs, outputs, (), through, output_after_set=True, starts={})
    return Run(MappedUnit("echo", ours, BlockUnit("echo", Echo), adaptation))


def links(signals, relation, end):
    """Each signal and where in the echo's numbers it is."""
    at = np.cumsum([0, *(v.size for v in signals)])
    return tuple(
        Link(
            v.name,
            tuple((end, int(first) + j) for j in range(v.size)),
            relation if v.quantity.type.is_float else Linear(),
            low=-40.0 if v.name == "state.x" else -np.inf,
        )
        for v, first in zip(signals, at[:-1], strict=True)
    )


CONVENTIONS = {
    "none": {},
    "reference point": {"state": (ReferencePoint(-1.3),), "obstacles": (BoxEnd(-0.5),)},
    "velocities": {"state": (SpeedAndSlip(),)},
    "both": {"state": (RoadFrameVelocity(), ReferencePoint(0.7))},
}


def random_values(run, signals, seed):
    rng = np.random.default_rng(seed)
    for v in signals:
        run.slot(v.name)[:] = (
            rng.integers(0, 2, v.size) if not v.quantity.type.is_float else rng.uniform(-50, 50, v.size)
        )


@pytest.mark.parametrize("name", CONVENTIONS)
def test_inputs_are_made_as_by_the_mapped_unit(name):
    """The echo shows what it was given."""
    adaptation = Adaptation(
        inputs=links(OURS, Linear(-1.8, 3.0), "u.n"), conventions=CONVENTIONS[name], passed_on=("y.n",)
    )
    adapter = input_adapter("some_in", Part(adaptation, OURS, THEIRS, H))
    made, expected = Run(BlockUnit("made", adapter.block)), mapped(adaptation, OURS, THEIRS.outputs)
    for seed in (1, 2):
        for one in (made, expected):
            random_values(one, OURS, seed)
            one.step()
        for place, port in adapter.sets.items():
            assert made.slot(port)[0] == pytest.approx(expected.slot("y.n")[place[1]], rel=1e-13, abs=1e-13), port
    assert len(adapter.sets) == 70


@pytest.mark.parametrize("name", CONVENTIONS)
def test_signals_are_made_as_by_the_mapped_unit(name):
    """The echo is given what it is to show."""
    missing = OURS[-1].name
    known = tuple(v for v in OURS if v.name != missing)
    adaptation = Adaptation(
        inputs=(Link("u.n", tuple(("u.n", i) for i in range(70))),),
        outputs=links(known, Linear(-1.8, 3.0), "y.n"),
        constants={missing: [2.5] * 8},
        conventions=CONVENTIONS[name],
    )
    adapter = output_adapter("some_out", Part(adaptation, OURS, THEIRS, H))
    made, expected = Run(BlockUnit("made", adapter.block)), mapped(adaptation, THEIRS.inputs, OURS)
    for seed in (1, 2):
        random_values(expected, THEIRS.inputs, seed)
        expected.slot("u.n")[6:22] = np.arange(16) % 2
        for (_, element), port in adapter.reads.items():
            made.slot(port)[0] = expected.slot("u.n")[element]
        for one in (made, expected):
            one.step()
        for v in OURS:
            assert made.slot(v.name) == pytest.approx(expected.slot(v.name), rel=1e-13, abs=1e-13), v.name


@pytest.mark.parametrize("present", [None, Link("state.psi", (("y.n", 1),), Linear(0.5))])
@pytest.mark.parametrize("limit", [np.inf, 2.0])
def test_a_rate_leads_to_the_signal_as_that_of_the_mapped_unit(present, limit):
    psi = tuple(v for v in OURS if v.name == "state.psi")
    rate = RateInput(Link("state.psi", (("u.n", 0),), Linear(2.0)), present, limit)
    adaptation = Adaptation(rates=(rate,), passed_on=("y.n",))
    adapter = input_adapter("some_in", Part(adaptation, psi, THEIRS, H))
    made, expected = Run(BlockUnit("made", adapter.block)), mapped(adaptation, psi, THEIRS.outputs)
    for wanted in (0.3, 0.35, -0.2):
        for one in (made, expected):
            one.slot("state.psi")[0] = wanted
            one.step()
        assert made.slot("theirs.u_n_1")[0] == pytest.approx(expected.slot("y.n")[0], rel=1e-13)
    assert set(adapter.reads) == ({("y.n", 1)} if present else set())


@pytest.mark.parametrize(("early", "shown"), [(False, [0.0, 0.1, -0.2]), (True, [0.1, 0.2, -0.1])])
def test_a_rate_is_integrated_from_the_step_that_leads_to_the_first_sample_or_from_it(early, shown):
    psi = tuple(v for v in OURS if v.name == "state.psi")
    adaptation = Adaptation(outputs=(Link("state.psi", (("y.n", 0),)),), integrated=("state.psi",))
    made = Run(BlockUnit("made", output_adapter("o", Part(adaptation, psi, THEIRS, H, early=early)).block))
    found = []
    for rate in (1.0, 1.0, -3.0):
        made.slot("theirs.y_n_1")[0] = rate
        made.step()
        found.append(made.slot("state.psi")[0])
    assert found == pytest.approx(shown)


def test_names_that_are_alike_without_their_signs_become_two_ports():
    theirs = replace(THEIRS, inputs=tuple(Variable(n, Quantity("", "n")) for n in ("a.b", "a_b", "1")))
    psi = tuple(v for v in OURS if v.name == "state.psi")
    adaptation = Adaptation(inputs=tuple(Link("state.psi", ((v.name, 0),)) for v in theirs.inputs))
    adapter = input_adapter("some_in", Part(adaptation, psi, theirs, H))
    assert list(adapter.sets.values()) == ["theirs.a_b", "theirs.a_b_2", "theirs.v_1"]


def test_what_a_block_is_made_from_is_its_definition():
    """A built FMU is used again where nothing has changed."""
    parts = [Adaptation(inputs=links(OURS, Linear(factor), "u.n")) for factor in (2.0, 2.0, 3.0)]
    first, same, other = (input_adapter("some_in", Part(p, OURS, THEIRS, H)).block.definition for p in parts)
    assert first == same != other
