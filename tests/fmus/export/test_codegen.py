"""C from functions: full columns, names of our own, one row of values.

Shows, of `fmus/export`, `codegen.py` and `fmi_variables.py`.
"""
# pyright: basic
# CasADi carries few types.

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from components import BLOCKS
from fmus.export import codegen
from fmus.export.codegen import equations_source, variables_source
from fmus.export.fmi_variables import fmi_variables_of
from fmus.lowering import lower

RAMP = BLOCKS["ramp_traffic"]


@pytest.mark.parametrize("graph", [ca.SX, ca.MX])
def test_structural_zeros_are_written_out(graph: type) -> None:
    x = graph.sym("x", 2)
    sparse = ca.vertcat(x[0], graph(1, 1), x[1])
    function = ca.Function("step", [x], [sparse], ["x"], ["y"])
    assert not function.sparsity_out(0).is_dense()
    made = codegen._exported(function)
    assert made.name() == "model_step"
    assert made.sparsity_out(0).is_dense()
    assert np.array(made([2.0, 3.0])).ravel().tolist() == [2.0, 0.0, 3.0]


def test_a_sampled_block_has_its_equations_once() -> None:
    text = equations_source(lower(BLOCKS["coast"]))
    assert "int model_step(" in text
    assert "int model_output(" not in text


def test_a_solve_and_a_third_lane_stand_once_behind_an_if() -> None:
    text = equations_source(lower(BLOCKS["mpc"]))
    for name in ("iterate", "by_third_lane"):
        assert text.count(f"/* {name}:") == 1
    assert text.count("if (arg[0] ? casadi_to_int(*arg[0]) : 0) {") == 2


def test_generating_twice_gives_the_same_text() -> None:
    assert equations_source(lower(RAMP)) == equations_source(lower(RAMP))


def test_value_references_count_all_elements_from_one() -> None:
    start = np.arange(72.0)
    interface = fmi_variables_of(RAMP, sampled=False, start=start)
    references = [reference for v in interface for reference in v.references]
    assert references == list(range(1, len(references) + 1))
    assert [value for v in interface.parameters for value in v.start] == start.tolist()


def test_start_parameters_are_fixed_and_others_tunable() -> None:
    interface = fmi_variables_of(RAMP, sampled=False, start=np.zeros(72))
    found = {v.name: v.variability for v in interface}
    assert found["x_start"] == "fixed"
    assert found["v_final"] == "tunable"
    assert found["ego.x"] == "continuous"
    assert found["obstacles.id"] == "discrete"


def test_outputs_of_a_sampled_block_are_discrete() -> None:
    interface = fmi_variables_of(BLOCKS["coast"], sampled=True, start=np.zeros(0))
    assert {v.variability for v in interface.outputs} == {"discrete"}


def test_table_has_every_element_and_its_variable() -> None:
    interface = fmi_variables_of(RAMP, sampled=False, start=np.zeros(72))
    text = variables_source(interface, "token")
    assert '{"obstacles.valid", BOOLEAN, OUTPUT, ' in text
    assert '{"length", FLOAT64, TUNABLE_PARAMETER, 57, 8, 0.0, INFINITY}' in text
    owners = text.partition("variable_of[] = {")[2].partition("}")[0].split(",")[:-1]
    states = sum(v.size for v in RAMP.states())
    assert len(owners) == 1 + sum(v.variable.size for v in interface) + states
