"""Every expression that is supported means what Modelica says; every other is refused by name, with file and line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from fmus.modelica.explicit import explicit
from fmus.modelica.flat import EXPLICIT, read

A, B = 0.3, 0.7


def value(path) -> np.ndarray:
    """The outputs of a model without states, with the inputs a and b."""
    return np.asarray(explicit(read(path)).evaluate([], [A, B], [])[1]).ravel()


def model(*expressions: str, kind: str = "Real") -> str:
    outputs = "".join(f"  output {kind} y{i};\n" for i in range(len(expressions)))
    equations = "".join(f"  y{i} = {text};\n" for i, text in enumerate(expressions))
    return f"block M\n  input Real a;\n  input Real b;\n{outputs}equation\n{equations}end M;\n"


NUMBERS = {
    "-a^2": -(A**2),
    "(-a)^2": A**2,
    "-a*b": -A * B,
    "-a - b": -A - B,
    "a - b - 1": A - B - 1,
    "a - (b - 1)": A - (B - 1),
    "a/b/2": A / B / 2,
    "a/(b/2)": A / (B / 2),
    "-(-a)": A,
    "+a": A,
    "2*a + b*3": 2 * A + B * 3,
    "2^(-a)": 2**-A,
    "(a^b)^2": (A**B) ** 2,
    "1/2": 0.5,
    "1.5e-3": 0.0015,
    "a^0.5": A**0.5,
    "sin(a)": math.sin(A),
    "cos(a)": math.cos(A),
    "tan(a)": math.tan(A),
    "asin(a)": math.asin(A),
    "acos(a)": math.acos(A),
    "atan(a)": math.atan(A),
    "atan2(-a, b)": math.atan2(-A, B),
    "sinh(a)": math.sinh(A),
    "cosh(a)": math.cosh(A),
    "tanh(a)": math.tanh(A),
    "exp(-a)": math.exp(-A),
    "log(a)": math.log(A),
    "log10(a)": math.log10(A),
    "sqrt(a)": math.sqrt(A),
    "abs(-a)": A,
    "sign(-a)": -1.0,
    "min(a, b)": A,
    "max(a, b)": B,
    "if a > b then 1 else 2": 2.0,
    "if a > b then 1 elseif a > 0 then 2 elseif a > -1 then 3 else 4": 2.0,
    "-(if a < b then a else b)": -A,
    "if a <= 0.3 and not b >= 1 then 1 else 0": 1.0,
    "if a > b or 1 == 1 then 1 else 0": 1.0,
    "noEvent(if a > 0 then 1/a else 0)": 1 / A,
    "if a > 1 then sqrt(a - 1) else 0": 0.0,
    "smooth(1, a)": A,
}


def test_numbers_are_those_that_modelica_means(written):
    found = value(written(model(*NUMBERS)))
    assert found == pytest.approx(list(NUMBERS.values()), rel=1e-15, abs=1e-15)


def test_booleans_are_true_or_false(written):
    found = value(written(model("a < b", "a > b", "not (a < b)", "true", "a < b and false", kind="Boolean")))
    assert found.tolist() == [1.0, 0.0, 0.0, 1.0, 0.0]


def test_arrays_go_element_by_element(written):
    text = """block M
  input Real a;
  input Real b;
  output Real y[3];
  output Real z[3];
  output Real w;
equation
  y = {a, b, 1} + 2*ones(3) - fill(a, 3);
  z = y.*{1, 2, 3}./y;
  w = y[2] + z[3];
end M;
"""
    found = value(written(text))
    y = np.array([A, B, 1.0]) + 2 - A
    assert found == pytest.approx([*y, 1, 2, 3, y[1] + 3], rel=1e-15)


REFUSED = {
    "time": "`time`",
    "mod(a, 2)": "the function `mod`",
    "floor(a)": "the function `floor`",
    "max({a, b})": "the function `max` of an array",
    "{a, b}*{a, b}": "the operator `Mul` between arrays",
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_is_not_supported_is_refused_by_name_with_file_and_line(written, text):
    path = written(model("a", text))
    with pytest.raises(RequestError) as refused:
        value(path)
    (problem,) = refused.value.problems
    assert (problem.where, problem.found) == (f"{path}:8", REFUSED[text])


def test_all_that_is_not_supported_is_told_at_once(written):
    path = written(model("a*time", "b", "ceil(a)"))
    with pytest.raises(RequestError) as refused:
        value(path)
    functions = (
        "abs, acos, asin, atan, atan2, cos, cosh, der, exp, fill, log, log10, max, min, noEvent, ones, sign, sin, "
        "sinh, smooth, sqrt, tan, tanh, zeros"
    )
    assert str(refused.value) == (
        f"{path}:8: found `time`; valid: {EXPLICIT}. Add a state t with der(t) = 1.\n"
        f"{path}:10: found the function `ceil`; valid: {functions}"
    )


def test_a_function_of_ones_own_is_refused(written):
    path = written(
        """package P
  function f
    input Real u;
    output Real y;
  algorithm
    y := u;
  end f;
  block M
    input Real a;
    output Real y;
  equation
    y = f(a);
  end M;
end P;
"""
    )
    with pytest.raises(RequestError) as refused:
        explicit(read(path))
    (problem,) = refused.value.problems
    assert (problem.where, problem.found, problem.remedy) == (
        f"{path}:12",
        "the function `f`",
        "Write its equations out.",
    )


def test_a_length_that_a_parameter_gives_is_refused(written):
    path = written(
        """block M
  parameter Integer k = 3;
  input Real u;
  output Real y[3];
equation
  y = fill(u, k);
end M;
"""
    )
    with pytest.raises(RequestError) as refused:
        explicit(read(path))
    assert str(refused.value) == (
        f"{path}:6: found arguments that `fill` cannot take here; valid: scalars and one-dimensional arrays; a length"
        " that a number or a constant gives"
    )
