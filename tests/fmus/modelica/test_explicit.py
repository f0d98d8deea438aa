"""Equations are solved one after the other, whichever their order; what cannot be is refused with file and line."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from fmus.modelica.explicit import explicit
from fmus.modelica.flat import EXPLICIT, read


def solve(path):
    return explicit(read(path))


def refusal(path) -> str:
    with pytest.raises(RequestError) as refused:
        solve(path)
    return str(refused.value)


def body(equations: str, declarations: str = "", initial: str = "") -> str:
    return f"block M\n{declarations}{initial}equation\n{equations}end M;\n"


def test_equations_may_stand_in_any_order_and_form(written):
    text = body(
        "  y = b;\n  2*b + 3 = a - x;\n  a + u = 5*x;\n  -k*der(x) = y;\n",
        "  input Real u;\n  output Real y;\n  parameter Real k;\n  Real a;\n  Real b;\n  Real x(start = 7);\n",
    )
    found = solve(written(text))
    x, u, k = 7.0, 0.5, 4.0
    a = 5 * x - u
    b = (a - x - 3) / 2
    dx, y = (np.asarray(column).ravel() for column in found.evaluate([x], [u], [k]))
    assert (dx, y) == (pytest.approx([-b / k], rel=1e-15), pytest.approx([b], rel=1e-15))
    assert np.asarray(found.start([k])).ravel().tolist() == [7.0]


def test_an_output_may_be_a_state_and_a_derivative_may_be_used_elsewhere(written):
    text = body("  der(x) = 2*x;\n  y = der(x) + x;\n", "  output Real x(start = 3);\n  output Real y;\n")
    found = solve(written(text))
    dx, y = (np.asarray(column).ravel().tolist() for column in found.evaluate([3.0], [], []))
    assert (dx, y) == ([6.0], [3.0, 9.0])


def test_components_are_connected(written):
    text = """block M
  connector RealInput = input Real;
  connector RealOutput = output Real;
  block Integrator
    RealInput u;
    RealOutput y(start = y_start);
    parameter Real y_start = 0;
  equation
    der(y) = u;
  end Integrator;
  RealInput u;
  RealOutput y;
  Integrator speed(y_start = 2);
  Integrator position;
equation
  connect(u, speed.u);
  connect(speed.y, position.u);
  connect(position.y, y);
end M;
"""
    found = solve(written(text))
    assert [v.name for v in found.parameters] == ["speed.y_start", "position.y_start"]
    assert [v.name for v in found.states] == ["speed.y", "position.y"]
    dx, y = (np.asarray(column).ravel().tolist() for column in found.evaluate([2.0, 5.0], [0.5], [2.0, 0.0]))
    assert (dx, y) == ([0.5, 2.0], [5.0])
    assert np.asarray(found.start([2.0, 1.0])).ravel().tolist() == [2.0, 1.0]


def test_arrays_of_states(written):
    text = body(
        "  der(v) = -k*v + {u, 0};\n  y = v;\n",
        "  input Real u;\n  output Real y[2];\n  parameter Real k = 2;\n  Real v[2](start = {1, 3});\n",
    )
    found = solve(written(text))
    dx, _ = (np.asarray(column).ravel().tolist() for column in found.evaluate([1.0, 3.0], [0.5], [2.0]))
    assert dx == [-1.5, -6.0]
    assert np.asarray(found.start([2.0])).ravel().tolist() == [1.0, 3.0]


@pytest.mark.parametrize(
    ("declared", "initial", "expected"),
    [
        ("start = 4", "", 4.0),
        ("start = 2*k", "", 6.0),
        ("", "", 0.0),
        ("", "initial equation\n  x = 2*k;\n", 6.0),
        ("start = 9", "initial equation\n  2*y = k;\n", 1.5),  # the initial equation wins
        ("start = 9", "initial equation\n  der(x) = 0;\n", 3.0),  # at rest
    ],
)
def test_the_initial_state(written, declared, initial, expected):
    text = body(
        "  der(x) = k - x;\n  y = x;\n", f"  parameter Real k;\n  output Real y;\n  Real x({declared});\n", initial
    )
    assert float(solve(written(text)).start([3.0])) == expected


def test_dependent_parameters_and_constants(written):
    text = body(
        "  y = hidden + twice;\n",
        "  constant Real c = 10;\n  parameter Real k = 3;\n"
        "  parameter Real twice = 2*other;\n  parameter Real other = k + c;\n  output Real y;\n"
        "protected\n  parameter Real hidden = other;\n",
    )
    found = solve(written(text))
    assert [v.name for v in found.parameters] == ["k"]
    assert float(found.evaluate([], [], [5.0])[1]) == 15 + 30


def test_declarations_may_hold_equations(written):
    text = """block M
  block Gain
    input Real u;
    output Real y = k*u;
    parameter Real k = 2;
  end Gain;
  input Real u;
  output Real y = twice.y + half[2];
  Real half[2] = {u/2, u/4};
  Gain twice(u = half[1]);
end M;
"""
    assert float(solve(written(text)).evaluate([], [8.0], [2.0])[1]) == 2 * 4 + 2


def test_an_input_with_a_value_is_refused(written):
    path = written("block M\n  input Real u = 1;\n  output Real y = u;\nend M;\n")
    assert refusal(path) == f"{path}:2: found the input `u` with a value; valid: an input without one"


def test_an_algebraic_loop_is_refused_with_all_its_equations(written):
    path = written(body("  x = cos(y);\n  y = x/2;\n", "  output Real x;\n  output Real y;\n"))
    assert refusal(path) == (
        f"{path}:5: found an algebraic loop between `x`, `y`; valid: {EXPLICIT}. Its other equations: {path}:6. "
        "Solve them by hand."
    )


def test_an_equation_that_is_not_linear_in_its_unknown_is_refused(written):
    path = written(body("  y^3 = u;\n", "  input Real u;\n  output Real y;\n"))
    assert refusal(path) == (f"{path}:5: found an equation that is not linear in its unknown `y`; valid: {EXPLICIT}")


def test_an_equation_too_many_is_refused(written):
    path = written(body("  y = 1;\n  y = 2;\n  z + w = 1;\n", "  output Real y;\n  output Real z;\n  output Real w;\n"))
    assert refusal(path) == f"{path}:7: found an equation without an unknown that is left to it; valid: {EXPLICIT}"


def test_an_initial_state_that_depends_on_inputs_is_refused(written):
    path = written(
        body("  der(x) = u - x;\n", "  input Real u;\n  output Real x;\n", "initial equation\n  der(x) = 0;\n")
    )
    assert refusal(path) == (
        f"{path}: found an initial state that depends on `u`; valid: initial values that parameters and constants give"
    )


def test_a_dependent_parameter_without_a_value_is_refused(written):
    path = written(body("  y = k;\n", "  output Real y;\nprotected\n  parameter Real k;\n"))
    assert refusal(path) == f"{path}:4: found no value for `k`; valid: a value, from parameters and constants"
