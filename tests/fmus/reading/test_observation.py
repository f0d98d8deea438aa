"""The variables of an FMU that can be recorded besides its outputs."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type
from fmus.reading.observation import observable, observing
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, pack, scalar
from tests.orchestrator.ssps import echo_library

UNIT = '<UnitDefinitions><Unit name="km/h"/></UnitDefinitions>'
LOCAL_BY_DEFAULT = '<ScalarVariable name="der(v)" valueReference="3"><Real/></ScalarVariable>'


def fmi2(folder):
    variables = [
        scalar("y", 0, "output"),
        scalar("v", 1, "local", of_unit="km/h"),
        scalar("same as v", 1, "local"),
        LOCAL_BY_DEFAULT,
        scalar("x[1]", 4, "local", "Integer", variability="discrete"),
        scalar("x[2]", 5, "local", "Integer", variability="discrete"),
        scalar("k", 6, "parameter", variability="fixed", of_start="2"),
        scalar("twice k", 7, "calculatedParameter", variability="fixed"),
    ]
    unknown = ['<Unknown index="1"/>', '<Unknown index="8"/>']
    text = description2(variables, unknown[:1], before=UNIT, initial=unknown)
    return open_fmu(pack(folder / "a.fmu", Version.FMI2, text, echo_library(Version.FMI2)))


def fmi3(folder, start="1 2 3"):
    variables = [
        '<Float64 name="y" valueReference="1" causality="output"><Alias name="also y"/></Float64>',
        '<Float64 name="w" valueReference="2" causality="local"><Dimension valueReference="4"/></Float64>',
        f'<Float64 name="x" valueReference="3" start="{start}" initial="exact"><Dimension start="3"/></Float64>',
        '<UInt64 name="n" valueReference="4" causality="structuralParameter" variability="fixed" start="2"/>',
        '<Clock name="c" valueReference="5" causality="local" intervalVariability="triggered"/>',
    ]
    text = description3(variables, ['<Output valueReference="1"/>', '<InitialUnknown valueReference="1"/>'])
    return open_fmu(pack(folder / "a.fmu", Version.FMI3, text, echo_library(Version.FMI3)))


def test_local_variables_and_parameters_can_be_observed(tmp_path):
    assert observable(fmi2(tmp_path)) == {
        **dict.fromkeys(("v", "same as v", "der(v)", "x[1]", "x[2]"), "local"),
        "k": "parameter",
        "twice k": "calculatedParameter",
    }
    assert observable(fmi3(tmp_path)) == {"w": "local", "x": "local", "n": "structuralParameter"}


def test_what_is_observed_stands_behind_the_outputs_in_the_order_of_the_file(tmp_path):
    archive = observing(fmi2(tmp_path), ["x[2]", "same as v", "v"], {})
    assert [v.name for v in archive.interface.recorded] == ["y", "v", "same as v", "x[2]"]
    assert [v.name for v in archive.interface.outputs] == ["y"]
    quantities = [v.quantity for v in archive.interface.observed]
    assert [(q.type, q.unit) for q in quantities] == [(Type.FLOAT64, "km/h"), (Type.FLOAT64, ""), (Type.INT32, "1")]
    assert [archive.references[name] for name in ("v", "same as v", "x[2]")] == [[1], [1], [5]]
    assert [v.name for v in observing(archive, ["k"], {}).interface.observed] == ["k"]


def test_lengths_follow_the_structural_parameters(tmp_path):
    shapes = [v.shape for v in observing(fmi3(tmp_path), ["w", "x"], {"n": 5}).interface.observed]
    assert shapes == [(5,), (3,)]


def test_a_variable_that_cannot_be_understood_is_refused_when_it_is_asked_for(tmp_path):
    text = description2([scalar("y", 0, "output"), scalar("v", 1, "local", of_start="one")], ['<Unknown index="1"/>'])
    archive = open_fmu(pack(tmp_path / "a.fmu", Version.FMI2, text, echo_library(Version.FMI2)), lenient=True)
    with pytest.raises(RequestError) as error:
        observing(archive, ["v"], {})
    found = "found a variable that cannot be understood (`v` with the start value `one`); valid: what FMI allows"
    assert str(error.value) == f"{archive.path}, modelDescription.xml, line 7: {found}"
