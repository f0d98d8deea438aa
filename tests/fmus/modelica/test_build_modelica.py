"""From a Modelica file to an FMU, which is rebuilt when the text changes and not otherwise."""

from __future__ import annotations

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from components.interfaces.problem import RequestError
from fmus.modelica.build_modelica import build_modelica, file_of, is_modelica
from fmus.modelica.flat import library
from fmus.toolchain.version import WRITTEN_VERSIONS, Version


@pytest.mark.parametrize(
    ("request_", "expected"),
    [("a.mo", True), ("/b/a.mo:P.M", True), ("a.fmu", False), ("bicycle", False), ("a.mo:", False), (".mo", False)],
)
def test_what_is_a_modelica_file(request_, expected):
    assert is_modelica(request_) is expected


def test_the_file_of_a_request_has_no_model_in_its_name():
    assert [str(file_of(request)) for request in ("a.mo:P.M", "/b/a.mo", "a.fmu")] == ["a.mo", "/b/a.mo", "a.fmu"]


@pytest.mark.parametrize("version", WRITTEN_VERSIONS)
def test_the_fmu_is_valid(tmp_path, version):
    built = build_modelica(str(library() / "Examples" / "PaperBicycle.mo"), version, tmp_path)
    assert built.path == tmp_path / f"fmi{version}" / "MacroStep_Examples_PaperBicycle.fmu"
    assert validate_fmu(str(built.path)) == []


@pytest.mark.parametrize("version", WRITTEN_VERSIONS)
def test_units_that_our_own_blocks_do_not_have_are_defined_in_the_fmu(tmp_path, car, version):
    declarations = '  parameter Real rho(unit = "kg/m3") = 1.2;\n  parameter Real v(unit = "km/h") = 36;'
    built = build_modelica(str(car(declarations)), version, tmp_path)
    assert validate_fmu(str(built.path)) == []
    units = {u.name: u.baseUnit for u in read_model_description(str(built.path)).unitDefinitions}
    assert (units["kg/m3"].kg, units["kg/m3"].m, units["kg/m3"].factor) == (1, -3, 1.0)
    assert (units["km/h"].m, units["km/h"].s) == (1, -1)
    assert units["km/h"].factor == pytest.approx(1 / 3.6, rel=1e-12)


@pytest.mark.parametrize("version", WRITTEN_VERSIONS)
def test_a_model_without_units_is_a_valid_fmu_without_units(tmp_path, written, version):
    text = "block M\n  parameter Real k = 2;\n  input Real u;\n  output Real y = k*u;\nend M;\n"
    built = build_modelica(str(written(text)), version, tmp_path)
    assert validate_fmu(str(built.path)) == []
    found = {v.name: v.unit for v in read_model_description(str(built.path)).modelVariables}
    assert {name: found[name] for name in ("k", "u", "y")} == {"k": None, "u": None, "y": None}


def test_it_is_built_again_only_when_the_text_has_changed(tmp_path, car):
    def built(equations: str):
        return build_modelica(f"{car('', equations)}:Car", Version.FMI3, tmp_path)

    first = built("  der(state.v_x) = actuation.T_r;")
    again = built("  der(state.v_x) = actuation.T_r;")
    changed = built("  der(state.v_x) = 2*actuation.T_r;")
    assert (first.rebuilt, again.rebuilt, changed.rebuilt) == (True, False, True)


def test_parameters_without_a_value_are_told_all_at_once(tmp_path, car):
    path = car('  parameter Real m(unit = "kg", min = 1);\n  parameter Real k;')
    with pytest.raises(RequestError) as refused:
        build_modelica(str(path), Version.FMI3, tmp_path)
    remedy = "Parameters have no default: give it a start value."
    assert str(refused.value) == (
        f"Car.m: found no value; valid: 1 <= finite number [kg]. {remedy}\n"
        f"Car.k: found no value; valid: finite number. {remedy}"
    )
