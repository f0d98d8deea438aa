"""What rumoca says of a file that it does not compile, as a refusal with place and remedy; also where it dies of it.

Shows `rumoca_library.py` and `rumoca_process.py`.
"""

from __future__ import annotations

import re
import sys

import pytest

from components.interfaces.problem import RequestError
from fmus.modelica import rumoca_library
from fmus.modelica.flat import library
from fmus.modelica.rumoca_library import compiled_model


def refusal(path, model=None) -> str:
    with pytest.raises(RequestError) as refused:
        compiled_model(path, model, [library()])
    return str(refused.value)


def test_text_that_is_no_modelica_is_refused_with_its_line(written):
    path = written("block M\n  Real x\nequation\nend M;\n")
    assert refusal(path) == f"{path}:2: found text that is no Modelica (unexpected `x`); valid: a Modelica class"


def test_one_of_several_models_has_to_be_named(written):
    path = written("package P\n  block A\n  end A;\n  block B\n  end B;\nend P;\n")
    assert refusal(path) == f"{path}: found several models; valid: one of P.A, P.B. Name it: {path}:MODEL."
    assert compiled_model(path, "P.B", [library()]).name == "P.B"


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


def test_a_file_that_is_no_utf8_is_refused_with_the_line(tmp_path):
    path = tmp_path / "A.mo"
    path.write_bytes(b'block A\n "\xff" end A;')
    assert refusal(path) == (
        f"{path}:2: found a byte that is no UTF-8 (0xff); valid: a Modelica file in UTF-8."
        " Save it again in that encoding."
    )


def test_files_beside_it_are_not_read(written):
    path = written("block M\n  output Real y;\nequation\n  y = 1;\nend M;\n")
    (path.parent / "B.mo").write_text("block B end")
    (path.parent / "C.mo").write_bytes(b"\xff" * 100)
    assert {name for _, name, _ in compiled_model(path, None, [library()]).sources} <= {str(path)} | {
        str(file) for file in library().rglob("*.mo")
    }


def test_the_files_of_a_package_are_read_together(tmp_path):
    folder = tmp_path / "P"
    folder.mkdir()
    (folder / "package.mo").write_text("package P\nend P;\n")
    (folder / "A.mo").write_text("within P;\nblock A\n  extends B;\nequation\n  y = 1;\nend A;\n")
    (folder / "B.mo").write_text("within P;\npartial block B\n  output Real y;\nend B;\n")
    assert compiled_model(folder / "A.mo", None, [library()]).name == "P.A"


def test_a_model_that_rumoca_dies_of_is_refused(written):
    path = written(f"block M\n  output Real y;\nequation\n  y = {'(' * 100_000}1{')' * 100_000};\nend M;\n")
    assert re.fullmatch(  # which of the two it is depends on the depth
        rf"{re.escape(str(path))}: found a model with which rumoca ends \(SIG(ABRT|SEGV)\); valid: a Modelica model"
        " that rumoca can flatten. Write it in a simpler way.",
        refusal(path),
    )


def test_a_model_that_takes_for_ever_is_refused(written, monkeypatch):
    monkeypatch.setattr(rumoca_library, "FLATTENING_TIME", 0.01)
    path = written("block M\nend M;\n")
    assert refusal(path) == (
        f"{path}: found a model that rumoca does not flatten within 0.01 s; valid: a Modelica model that rumoca can"
        " flatten"
    )


def test_a_file_beyond_all_reason_is_refused(tmp_path):
    path = tmp_path / "A.mo"
    path.write_bytes(b" " * (17 * 2**20))
    assert refusal(path) == f"{path}: found 17 MiB of Modelica; valid: at most 16 MiB in one file"
