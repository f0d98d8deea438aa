"""`macrostep build`, for blocks and for Modelica files, as a person types it."""

from __future__ import annotations

import filecmp
import shutil
import zipfile

from components import BLOCKS
from fmus.modelica.flat import library

BICYCLE = library() / "Examples" / "PaperBicycle.mo"


def test_build_writes_both_versions_beside_each_other(macrostep, in_tmp_path):
    code, out, _ = macrostep("build", BICYCLE)
    files = [f"fmi{version}/MacroStep_Examples_PaperBicycle.fmu" for version in (2, 3)]
    assert (code, out.split()) == (0, files)
    for file in files:
        assert zipfile.is_zipfile(in_tmp_path / file)


def test_build_takes_one_of_several_models_a_version_and_a_folder(macrostep, in_tmp_path):
    text = "package P\n  block A\n    extends MacroStep.Controller.Coast;\n  end A;\n  block B\n  end B;\nend P;\n"
    (in_tmp_path / "P.mo").write_text(text, encoding="utf-8")
    code, out, _ = macrostep("build", "P.mo:P.A", "--fmi", "3", "--out", "there")
    assert (code, out.split()) == (0, ["there/fmi3/P_A.fmu"])


def test_build_of_something_else_is_a_wrong_request(macrostep):
    code, _, err = macrostep("build", "bicycle", BICYCLE, "x.fmu")
    valid = "valid: a Modelica file: FILE.mo, or FILE.mo:MODEL"
    assert (code, err.splitlines()) == (
        2,
        [
            f"macrostep: macrostep build: found `bicycle`; {valid}",
            f"macrostep: macrostep build: found `x.fmu`; {valid}",
        ],
    )


def test_a_model_that_is_not_supported_is_a_wrong_request_with_its_line(macrostep, in_tmp_path):
    (in_tmp_path / "M.mo").write_text("model M\n  Real x = time;\nend M;\n", encoding="utf-8")
    code, _, err = macrostep("run", "static", "--plant", "M.mo", "--blocks")
    assert code == 2
    assert err.startswith("macrostep: M.mo:2: found `time`; valid: ")


def test_build_makes_what_is_missing_and_says_where_the_fmus_are(macrostep, in_tmp_path, built_fmus):
    shutil.copytree(built_fmus / "fmi2", in_tmp_path / "built" / "fmi2")
    (in_tmp_path / "built" / "fmi2" / "mpc.fmu").unlink()
    code, out, _ = macrostep("build", "--out", "built", "--fmi", "2")
    assert code == 0
    native = [name for name, block in BLOCKS.items() if block.native]
    assert out == f"{len(native)} FMUs in built/\n"
    made = {path.stem: path for path in (in_tmp_path / "built").rglob("*.fmu")}
    assert made.keys() == set(native)
    # all bytes; pytest would compare a large difference for minutes
    assert all(filecmp.cmp(path, built_fmus / "fmi2" / path.name, shallow=False) for path in made.values())
