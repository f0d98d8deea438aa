"""What rumoca says of a file that it does not compile, as a refusal with place and remedy."""

from __future__ import annotations

import sys

import pytest

from components.interfaces.problem import RequestError
from fmus.modelica.flat import library
from fmus.modelica.rumoca_library import compiled_model


def refusal(path, model=None) -> str:
    with pytest.raises(RequestError) as refused:
        compiled_model(path, model, library())
    return str(refused.value)


def test_text_that_is_no_modelica_is_refused_with_its_line(written):
    path = written("block M\n  Real x\nequation\nend M;\n")
    assert refusal(path) == f"{path}:2: found text that is no Modelica (unexpected `x`); valid: a Modelica class"


def test_one_of_several_models_has_to_be_named(written):
    path = written("package P\n  block A\n  end A;\n  block B\n  end B;\nend P;\n")
    assert refusal(path) == f"{path}: found several models; valid: one of P.A, P.B. Name it: {path}:MODEL."
    assert compiled_model(path, "P.B", library()).name == "P.B"


def test_what_rumoca_refuses_is_passed_on(written):
    path = written("block M\n  output Real y;\n  output Real z;\nequation\n  y = 1;\nend M;\n")
    assert refusal(path).startswith(f"{path}: found what rumoca cannot compile: ")
    assert "unbalanced model: 1 equations, 2 unknowns" in refusal(path)
    assert refusal(path, "Other") == (
        f"{path}: found what rumoca cannot compile of `Other`: Other could not be compiled because resolve/parse "
        "failed; valid: a complete, balanced model"
    )


def test_without_rumoca_it_says_what_to_install(written, monkeypatch):
    path = written("block M\nend M;\n")
    monkeypatch.setitem(sys.modules, "rumoca", None)
    assert refusal(path) == (
        f"{path}: found a Modelica file, and no rumoca to read it; valid: rumoca. Install macrostep[modelica]."
    )
