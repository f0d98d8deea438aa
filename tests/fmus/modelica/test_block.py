"""A Modelica model as a block: the bicycle is ours to the last bit, and what does not fit is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components import BLOCKS
from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type
from components.interfaces.record import pack
from components.interfaces.sockets import PLANT
from fmus.lowering import lower
from fmus.modelica.block import OWN_NAMES, modelica_block
from fmus.modelica.flat import library
from orchestrator.scenario.catalogue import default_values

BICYCLE = library() / "Examples" / "PaperBicycle.mo"
OURS = BLOCKS["bicycle"]
P = pack(OURS(**default_values(OURS)))


def refusal(path) -> str:
    with pytest.raises(RequestError) as refused:
        modelica_block(path)
    return str(refused.value)


def order(theirs, ours) -> list[int]:
    """Where each of our variables stands among theirs; all are scalars."""
    names = [v.name for v in theirs]
    return [names.index(v.name) for v in ours]


@pytest.fixture(scope="module")
def bicycle():
    return modelica_block(BICYCLE)


def test_the_bicycle_has_the_signals_and_parameters_of_ours(bicycle):
    theirs = bicycle.block
    for mine, ours in (
        (theirs.inputs(), OURS.inputs()),
        (theirs.outputs(), OURS.outputs()),
        (theirs.parameters(), OURS.parameters()),
    ):
        assert {v.name: v.quantity for v in mine} == {v.name: v.quantity for v in ours}
    assert (theirs.name, theirs.socket.name) == ("MacroStep_Examples_PaperBicycle", "plant")
    assert theirs.summary == "The vehicle of the paper, driving at 10 m/s"


def test_the_example_has_the_values_of_our_parameter_set(bicycle):
    assert bicycle.start == default_values(OURS)


@given(
    x=st.tuples(*(st.floats(a, b) for a, b in ((-99, 99), (-9, 9), (-3, 3), (1, 40), (-3, 3), (-2, 2)))),
    u=st.tuples(st.floats(-0.78, 0.78), st.floats(-160, 200)),
    h=st.floats(1e-3, 0.01),
)
def test_outputs_and_steps_are_those_of_our_bicycle(bicycle, x, u, h):
    theirs, ours = lower(bicycle.block), lower(OURS)
    p = pack(bicycle.block(**bicycle.start))
    expected = np.asarray(ours.output(x, u, P)).ravel()
    found = np.asarray(theirs.output(x, u, p)).ravel()[order(bicycle.block.outputs(), OURS.outputs())]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(theirs.step(x, u, p, h), ours.step(x, u, P, h), rtol=1e-12, atol=1e-12)


def test_feedthrough_is_that_of_our_bicycle(bicycle):
    rows = order(bicycle.block.outputs(), OURS.outputs())
    assert (lower(bicycle.block).feedthrough[rows] == lower(OURS).feedthrough).all()


def test_with_plain_numbers_it_says_the_same_as_lowered(bicycle):
    block = bicycle.block(**bicycle.start)
    state, u = block.start(), np.array([0.1, 50.0])
    inputs = bicycle.block.input_type(actuation=next(iter(_groups(bicycle.block.input_type)))(delta_f=0.1, T_r=50.0))
    lowered = lower(bicycle.block)
    assert pack(state).tolist() == [0.0, 0.0, 0.0, 10.0, 0.0, 0.0]
    assert pack(block.output(state, inputs)) == pytest.approx(
        np.asarray(lowered.output(pack(state), u, pack(block))).ravel(), rel=1e-12
    )
    assert pack(block.step(state, inputs, 0.01)) == pytest.approx(
        np.asarray(lowered.step(pack(state), u, pack(block), 0.01)).ravel(), rel=1e-12
    )


def _groups(kind):
    return [f.type for f in kind.__dataclass_fields__.values()]


@pytest.mark.parametrize(("name", "ours"), [("Traffic/EmptyRoad", "empty_road"), ("Controller/Coast", "coast")])
def test_the_empty_plugs_show_what_ours_show(name, ours):
    made = modelica_block(library() / f"{name}.mo")
    theirs, reference = lower(made.block), lower(BLOCKS[ours])
    assert made.block.socket.name == BLOCKS[ours].socket.name
    assert [v.name for v in made.block.outputs()] == [v.name for v in BLOCKS[ours].outputs()]
    u = np.ones(sum(v.size for v in made.block.inputs()))
    x = np.zeros(reference.output.size1_in(0))
    p = pack(BLOCKS[ours](**default_values(BLOCKS[ours])))
    found, expected = theirs.output([], u, []), reference.output(x, u, p)
    if ours == "coast":
        assert np.asarray(found).tolist() == np.asarray(expected).tolist()
    else:
        assert not np.asarray(found).any()
        assert not np.asarray(expected)[: len(BLOCKS[ours].outputs()[0].elements)].any()


def test_parameters_of_components_lose_their_dots_and_keep_type_range_and_value(car):
    made = modelica_block(
        car(
            '  block Brake\n    parameter Real F(unit = "N", min = -1, max = 2*3) = -0.5 "force";\n'
            "    parameter Integer n = 2;\n    parameter Boolean on = true;\n  end Brake;\n  Brake brake;\n"
            "  parameter Real table[2] = {1, -2};",
            "  der(state.v_x) = if brake.on then brake.F*brake.n else table[2];",
        )
    )
    assert made.start == {"brake_F": -0.5, "brake_n": 2, "brake_on": True, "table": [1.0, -2.0]}
    quantities = {v.name: v.quantity for v in made.block.parameters()}
    force = quantities["brake_F"]
    assert (force.unit, force.description, force.min, force.max) == ("N", "force", -1.0, 6.0)
    assert (quantities["brake_n"].type, quantities["brake_on"].type) == (Type.INT32, Type.BOOLEAN)
    step = lower(made.block).step(np.zeros(2), np.zeros(2), pack(made.block(**made.start)), 0.01)
    assert np.asarray(step).ravel()[1] == pytest.approx(-0.01, rel=1e-12)


def test_a_model_that_fits_no_socket_keeps_its_own_names_and_units(written):
    made = modelica_block(
        written(
            """block Own
  input Real delta_f;
  input Real T_r(unit = "N.m", min = -200);
  output Real speed(unit = "km/h", start = 36, fixed = true);
  output Real path[2](each unit = "m");
equation
  der(speed) = T_r;
  path = {delta_f, 2*speed};
end Own;
"""
        )
    ).block
    assert made.socket is OWN_NAMES
    assert [(v.name, v.quantity.unit) for v in made.inputs()] == [("delta_f", ""), ("T_r", "N.m")]
    assert [(v.name, v.quantity.unit, v.shape) for v in made.outputs()] == [
        ("speed", "km/h", ()),
        ("path", "m", (2,)),
    ]
    assert np.asarray(lower(made).output([36.0], [0.5, 1.0], [])).ravel().tolist() == [36.0, 0.5, 72.0]


def test_a_model_that_fits_another_socket_than_the_one_it_is_for_has_names_of_its_own(car):
    path = car()
    assert modelica_block(path, socket="plant").block.socket is PLANT
    assert modelica_block(path, socket="traffic").block.socket is OWN_NAMES


@pytest.mark.parametrize(("unit", "fits"), [('(unit = "m/s")', True), ("", True), ('(unit = "km/h")', False)])
def test_a_model_fits_a_socket_in_its_units_or_without_units(written, unit, fits):
    numbers = {"x": '(unit = "m")', "y": '(unit = "m")', "psi": '(unit = "rad")', "v_x": unit, "v_y": "", "r": ""}
    declared = "\n".join(f"    Real {name}{of};" for name, of in numbers.items())
    equations = "\n".join(f"  state.{name} = 0;" for name in numbers)
    path = written(
        f"""block M
  MacroStep.Interfaces.ActuationInput actuation;
  record State
{declared}
  end State;
  connector StateOutput = output State;
  StateOutput state;
equation
{equations}
end M;
"""
    )
    assert modelica_block(path, socket="plant").block.socket is (PLANT if fits else OWN_NAMES)


def test_a_unit_that_nobody_knows_is_refused_with_its_line(car):
    path = car('  parameter Real k(unit = "furlong") = 1;')
    assert refusal(path) == f"{path}:3: found `k` in `furlong`; valid: a unit as Modelica writes it: kg, m/s2, N.m/rad"


def test_names_that_are_the_same_without_dots_are_refused(car):
    path = car("  block B\n    parameter Real k = 1;\n  end B;\n  B b;\n  parameter Real b_k = 2;")
    said = refusal(path)
    assert "`b_k`" in said
    assert "`b.k`" in said
    assert said.endswith("valid: names that differ without dots")


VALID = "valid: letters, digits and underscores that are no word of Python and no part of every block."


@pytest.mark.parametrize(
    ("declaration", "said"),
    [
        ("input Real lambda;", f"3: found the name `lambda`; {VALID} Rename it."),
        ("parameter Real step = 1;", f"3: found the name `step`; {VALID} Rename it."),
        ("input Real b_k; B b;", "3: found `b_k` beside `b.k`; valid: names that differ without dots"),
        (
            "input C cs[1];",
            f"2: found the name `cs[1].x`; {VALID} Write an array of each number in place of one of records.",
        ),
    ],
)
def test_names_that_a_block_cannot_have_are_refused(written, declaration, said):
    path = written(
        f"block M\n  record B parameter Real k = 1; end B; record C Real x; end C;\n  {declaration}\nend M;\n"
    )
    assert refusal(path).replace(str(path), "") == f":{said}"
