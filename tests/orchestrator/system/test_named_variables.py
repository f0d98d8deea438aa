"""What the names of variables mean: whole variables, elements, aliases."""

from __future__ import annotations

import pytest

from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable
from fmus.toolchain.version import Version
from orchestrator.system.named_variables import array_of, look_up, named, own_values, settable
from orchestrator.system.source import Fmu
from tests.fmus.foreign import description2, description3, pack, scalar
from tests.orchestrator.ssps import echo_library

MATRIX = Variable("m", Quantity("1", "m", shape=(2, 2)))


@pytest.mark.parametrize("name", ["m[1,2]", "m[1, 2]", "m[1][2]"])
def test_an_element_goes_by_any_spelling_of_its_index(name):
    assert look_up(name, named([MATRIX])).index == (1, 2)


def test_a_name_of_its_own_comes_before_an_element():
    own = Variable("m[1][2]", Quantity("1", "own"))
    assert look_up("m[1][2]", named([MATRIX, own])).variable == own


def test_what_is_no_name_means_nothing():
    known = named([MATRIX])
    assert look_up("m[3,1]", known) is None
    assert look_up("n", known) is None
    assert array_of("m[3][1]", known).variable == MATRIX
    assert array_of("n[1]", known) is None


def test_elements_are_spelled_as_in_the_file(tmp_path):
    variables = [scalar(f"z[{k}]", k, "parameter", variability="fixed", of_start="1") for k in (0, 1)]
    path = pack(tmp_path / "m.fmu", Version.FMI2, description2(variables), echo_library(Version.FMI2))
    assert {name: found.index for name, found in settable(Fmu(path)).items()} == {"z": None, "z[0]": (1,), "z[1]": (2,)}


def test_an_alias_means_its_variable(tmp_path):
    parameter = '<Float64 name="k" valueReference="1" causality="parameter" variability="fixed" start="2">'
    text = description3([parameter + '<Alias name="gain"/></Float64>'])
    path = pack(tmp_path / "m.fmu", Version.FMI3, text, echo_library(Version.FMI3))
    assert settable(Fmu(path))["gain"].variable.name == "k"


def test_a_parameter_without_a_value_is_told(tmp_path):
    variables = [scalar(f"p{k}", k, "parameter", variability="fixed") for k in range(14)]
    path = pack(tmp_path / "m.fmu", Version.FMI2, description2(variables), echo_library(Version.FMI2))
    source = Fmu(path, {"p0": 1.0}, lenient=True)
    assert own_values("a", source) == [
        "a: no start value in the file, the FMU keeps its own: p1, p2, p3, p4, p5, p6, p7, p8, p9, p10, p11, p12"
        " and 1 others"
    ]
