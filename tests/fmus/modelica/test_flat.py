"""What is read of a Modelica file, and what is refused before any equation is solved."""

from __future__ import annotations

from threading import Thread

import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type
from fmus.modelica.flat import EXPLICIT, library, read


def refusal(path, model=None) -> str:
    with pytest.raises(RequestError) as refused:
        read(path, model)
    return str(refused.value)


def test_a_refusal_may_be_let_go_of_by_another_thread(written):
    """rumoca's objects may not; the exception's frames held one, and the collector of garbage runs in any thread."""
    kept = []
    try:
        read(written("partial block M end M;"))
    except RequestError as error:
        kept.append(error)
    assert kept
    thread = Thread(target=kept.clear)
    thread.start()
    thread.join()


def test_variables_keep_type_role_unit_and_description(written):
    found = read(
        written(
            """block M "a model"
  type Mass = Real(unit = "kg", min = 0);
  parameter Mass m = 2 "mass";
  parameter Integer n;
  parameter Real twice(unit = "kg") = 2*m;
  final parameter Boolean flag = true;
  constant Real g = 9.81;
  input Real u(unit = "N");
  output Real y[2](each unit = "m");
  Real within_it;
protected
  parameter Real hidden = 3;
equation
  within_it = u;
  y = {within_it, m};
end M;
"""
        )
    )
    assert (found.name, found.summary) == ("M", "a model")
    kinds = {v.name: (v.role, v.type, v.shape, v.unit) for v in found.variables.values()}
    assert kinds == {
        "m": ("parameter", Type.FLOAT64, (), "kg"),
        "n": ("parameter", Type.INT32, (), ""),
        "twice": ("dependent", Type.FLOAT64, (), "kg"),
        "flag": ("dependent", Type.BOOLEAN, (), ""),
        "g": ("dependent", Type.FLOAT64, (), ""),
        "u": ("input", Type.FLOAT64, (), "N"),
        "y": ("output", Type.FLOAT64, (2,), "m"),
        "within_it": ("local", Type.FLOAT64, (), ""),
        "hidden": ("dependent", Type.FLOAT64, (), ""),
    }
    assert found.variables["m"].description == "mass"
    assert found.variables["n"].binding is None  # and not 0


def test_inputs_and_outputs_of_components_are_not_those_of_the_model(written):
    found = read(
        written(
            """block M
  block Gain
    input Real u;
    output Real y;
    parameter Real k = 2;
  equation
    y = k*u;
  end Gain;
  input Real u;
  output Real y;
  Gain first(k = 3);
equation
  first.u = u;
  y = first.y;
end M;
"""
        )
    )
    roles = {v.name: v.role for v in found.variables.values()}
    assert roles == {"u": "input", "y": "output", "first.u": "local", "first.y": "local", "first.k": "parameter"}


def test_equations_know_their_file_and_line(written):
    path = written("block M\n  output Real y;\n  output Real z;\nequation\n  y = 1;\n\n  z = 2;\nend M;\n")
    assert [e.place for e in read(path).equations] == [f"{path}:5", f"{path}:7"]


def test_the_definition_changes_with_the_text_and_with_the_model(written):
    text = (
        "package P\n  block A\n    output Real y = 1;\n  end A;\n  block B\n    output Real y = 1;\n  end B;\nend P;\n"
    )
    path = written(text)
    a, again, b = read(path, "P.A"), read(path, "P.A"), read(path, "P.B")
    changed = read(written(text.replace("y = 1", "y = 2")), "P.A")
    assert a.definition == again.definition
    assert len({a.definition, b.definition, changed.definition}) == 3


LEFT_OUT = {
    "when": ("  Real x(start = 1);\nequation\n  der(x) = 1;\n  when x > 2 then\n    reinit(x, 0);\n  end when;", 5),
    "algorithm": ("  Real x;\nalgorithm\n  x := 1;", 4),
    "assert": ('  Real x;\nequation\n  x = 1;\n  assert(x > 0, "no");', 5),
}
WORDS = {"when": "a `when` equation", "algorithm": "an `algorithm` section", "assert": "an `assert`"}


@pytest.mark.parametrize("kind", LEFT_OUT)
def test_what_is_left_out_is_refused_with_its_line(written, kind):
    body, line = LEFT_OUT[kind]
    path = written(f"model M\n{body}\nend M;\n")
    assert refusal(path) == f"{path}:{line}: found {WORDS[kind]}; valid: {EXPLICIT}"


def test_variables_of_other_kinds_are_refused_all_at_once(written):
    path = written(
        """model M
  type E = enumeration(a, b);
  E e = E.a;
  Real q[2, 2] = {{1, 2}, {3, 4}};
  parameter String s = "text";
end M;
"""
    )
    assert refusal(path).splitlines() == [
        f"{path}:3: found `e`, a variable of the type E; valid: Real, Integer or Boolean",
        f"{path}:4: found `q`, an array with 2 dimensions; valid: {EXPLICIT}",
        f"{path}:5: found `s`, a variable of the type String; valid: Real, Integer or Boolean",
    ]


def test_a_partial_model_is_refused():
    path = library() / "Interfaces" / "Plant.mo"
    assert refusal(path) == (
        f"{path}: found a partial model; valid: a model that is complete. Extend it, and fill what it leaves."
    )


def test_a_file_that_is_not_there_is_refused(tmp_path):
    assert refusal(tmp_path / "none.mo") == f"{tmp_path / 'none.mo'}: found no such file; valid: a Modelica file (.mo)"


def test_a_model_with_more_unknowns_than_can_be_solved_is_refused(written):
    path = written("block M\n  output Real y[20000];\nequation\n  y = ones(20000);\nend M;\n")
    assert refusal(path) == f"{path}: found 20000 unknowns or equations; valid: at most 10000. Split the model."
