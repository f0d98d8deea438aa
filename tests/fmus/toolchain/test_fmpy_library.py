"""What is used of FMPy is there, its private parts too."""

from __future__ import annotations

import subprocess
import sys

import pytest
from lxml import etree

from fmus.toolchain.fmpy_library import (
    C_HEADERS,
    FMI2_LOGGING_LIBRARY,
    SSP_SCHEMAS,
    DescriptionBreach,
    FMU2Model,
    FMU2Slave,
    FMU3Model,
    FMU3Slave,
    ModelDescriptionError,
    as_phrase,
    description_breaches,
    description_schema,
    read_model,
    required_functions,
    ssp_schema,
    sundials,
)
from fmus.toolchain.version import Version


@pytest.mark.parametrize("kind", ["Description", "ParameterValues", "ParameterMapping", "SignalDictionary"])
def test_every_kind_of_document_has_a_schema_that_judges(kind):
    name = f"SystemStructure{kind}.xsd"
    assert (SSP_SCHEMAS / name).is_file()
    assert not ssp_schema(name).validate(etree.fromstring("<a/>"))
    assert ssp_schema(name) is ssp_schema(name)


@pytest.mark.parametrize("version", Version)
def test_each_version_of_fmi_has_its_headers_and_a_schema_that_judges(version):
    assert (C_HEADERS / f"fmi{version}Functions.h").is_file()
    assert not description_schema(version).validate(etree.fromstring("<a/>"))


def test_the_library_that_formats_messages_is_there():
    assert FMI2_LOGGING_LIBRARY.is_file()


@pytest.mark.parametrize(
    ("fmu_class", "version", "own"),
    [
        (FMU2Slave, Version.FMI2, "fmi2DoStep"),
        (FMU2Model, Version.FMI2, "fmi2GetDerivatives"),
        (FMU3Slave, Version.FMI3, "fmi3DoStep"),
        (FMU3Model, Version.FMI3, "fmi3GetContinuousStateDerivatives"),
    ],
)
def test_the_functions_of_fmi_are_read_off_the_classes(fmu_class, version, own):
    found = required_functions(fmu_class, version)
    assert {own, f"fmi{version}FreeInstance", f"fmi{version}SetDebugLogging"} <= set(found)
    assert all(callable(getattr(fmu_class, name)) for name in found)


MODEL = """<?xml version="1.0"?>
<fmiModelDescription fmiVersion="{version}" modelName="m" guid="g">
<CoSimulation modelIdentifier="m"/>
<ModelVariables><ScalarVariable name="n" valueReference="1" causality="output" variability="continuous"{more}>
<Integer/></ScalarVariable>
<ScalarVariable name="y" valueReference="2" causality="output"><Real/></ScalarVariable></ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/><Unknown index="2" dependencies="1
  2"/></Outputs></ModelStructure></fmiModelDescription>"""


def model(version="2.0", more=""):
    return read_model(MODEL.format(version=version, more=more).encode(), Version.FMI2)


def test_fmpys_reports_on_a_description_become_data():
    text = "The variable `n`{} is of type Integer and must have variability != `continuous`"
    assert description_breaches(model(), with_structure=False) == [
        DescriptionBreach(text.format(" (line 4)"), text.format(""), line=4, concerns_variability=True)
    ]
    others = description_breaches(model(more=' initial="exact"'), with_structure=False)[1:]
    assert [(b.found, b.line, b.concerns_variability) for b in others] == [
        ("Variable `n` has no start value", 4, False)
    ]
    assert len(description_breaches(model(), with_structure=True)) > 1


def test_lists_in_several_lines_and_later_versions_are_read():
    found = model("2.0.4")
    assert found.fmiVersion == "2.0"
    assert [v.name for v in found.outputs[1].dependencies] == ["n", "y"]


def test_what_fmpy_cannot_read_is_told_in_one_line():
    with pytest.raises(ModelDescriptionError, match="^[^\n]+$"):
        read_model(MODEL.format(version="2.0", more="").replace('index="1"', 'index="7"').encode(), Version.FMI2)
    assert as_phrase('the "a"\n  of b.') == "the `a` of b"


def test_the_solver_has_the_parts_that_ours_extends():
    assert callable(sundials().CVodeSolver.f)
    assert callable(sundials().CVodeSolver.g)
    assert sundials() is sundials()


def test_the_solvers_libraries_are_loaded_only_when_they_are_asked_for():
    code = "import sys, fmus.units.make; print(*(m for m in sys.modules if m.startswith('fmpy.sundials')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("module", ["orchestrator.command.main", "fmus.export.build"])
def test_what_may_do_without_fmpy_does_not_import_it(module):
    done = subprocess.run(
        [sys.executable, "-c", f"import sys, {module}; print('fmpy' in sys.modules)"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "False"
