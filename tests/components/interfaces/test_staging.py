"""A staged part of the equations is the call itself, whatever it is fed with."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from components.interfaces.buses import Actuation
from components.interfaces.maths import sin
from components.interfaces.record import pack
from components.interfaces.staging import column_of, staged, staged_if, symbols


def _twice(first: Actuation, second: Actuation) -> Actuation:
    return Actuation(delta_f=sin(first.delta_f) + second.T_r, T_r=first.T_r * second.delta_f)


FIRST, SECOND = Actuation(delta_f=0.3, T_r=5.0), Actuation(delta_f=-0.2, T_r=7.0)


def test_with_numbers_it_is_the_call():
    assert pack(staged(_twice, Actuation, {}, FIRST, SECOND)).tolist() == pack(_twice(FIRST, SECOND)).tolist()


def test_with_graph_symbols_it_is_one_node_with_the_same_value():
    column, record = symbols(Actuation, {}, ca.MX)
    result = staged(_twice, Actuation, {}, record, SECOND)
    function = ca.Function("f", [column], [pack(result)])
    assert np.allclose(np.asarray(function(pack(FIRST))).ravel(), pack(_twice(FIRST, SECOND)), rtol=1e-15)
    assert any(function.instruction_id(i) == ca.OP_CALL for i in range(function.n_instructions()))


def test_with_scalar_symbols_it_is_the_call():
    column, record = symbols(Actuation, {}, ca.SX)
    function = ca.Function("f", [column], [pack(staged(_twice, Actuation, {}, record, SECOND))])
    assert np.allclose(np.asarray(function(pack(FIRST))).ravel(), pack(_twice(FIRST, SECOND)), rtol=1e-15)


@pytest.mark.parametrize("graph", [ca.SX, ca.MX])
@pytest.mark.parametrize("needed", [False, True])
def test_what_is_not_needed_is_zero_with_numbers_and_with_symbols(graph, needed):
    condition, (column, record) = graph.sym("c"), symbols(Actuation, {}, graph)
    result = staged_if(condition, _twice, Actuation, {}, record, SECOND)
    function = ca.Function("f", [condition, column], [pack(result)])
    number = pack(staged_if(needed, _twice, Actuation, {}, FIRST, SECOND))
    assert number.tolist() == (pack(_twice(FIRST, SECOND)).tolist() if needed else [0.0, 0.0])
    assert np.allclose(np.asarray(function(needed, pack(FIRST))).ravel(), number, rtol=1e-15)


@pytest.mark.parametrize("graph", [ca.SX, ca.MX])
def test_what_is_not_needed_stands_behind_an_if_in_the_generated_c(graph):
    condition, (column, record) = graph.sym("c"), symbols(Actuation, {}, graph)
    result = staged_if(condition, _twice, Actuation, {}, record, SECOND)
    generator = ca.CodeGenerator("f.c", {"with_export": False})
    generator.add(ca.Function("f", [condition, column], [pack(result)]))
    text = generator.dump()
    assert text.count("sin(") == 1
    assert "if (arg[0] ? casadi_to_int(*arg[0]) : 0) {" in text


def test_a_record_of_numbers_becomes_an_expression():
    assert isinstance(column_of(FIRST), ca.DM)
