"""What is used of FMPy is there, its private parts too.

With it `description_breach.py` and `description_repair.py`, which stand around it.
"""

from __future__ import annotations

import subprocess
import sys

import pytest
from lxml import etree

from fmus.toolchain.description_breach import DescriptionBreach, as_phrase, breach_of
from fmus.toolchain.fmpy_library import (
    C_HEADERS,
    FMI2_LOGGING_LIBRARY,
    SSP_SCHEMAS,
    FMU2Model,
    FMU2Slave,
    FMU3Model,
    FMU3Slave,
    ModelDescriptionError,
    description_breaches,
    description_schema,
    read_model,
    required_functions,
    ssp_schema,
    sundials,
)
from fmus.toolchain.version import WRITTEN_VERSIONS, Version


@pytest.mark.parametrize("kind", ["Description", "ParameterValues", "ParameterMapping", "SignalDictionary"])
def test_every_kind_of_document_has_a_schema_that_judges(kind):
    name = f"SystemStructure{kind}.xsd"
    assert (SSP_SCHEMAS / name).is_file()
    assert not ssp_schema(name).validate(etree.fromstring("<a/>"))
    assert ssp_schema(name) is ssp_schema(name)


@pytest.mark.parametrize("version", WRITTEN_VERSIONS)
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
    return read_model(etree.fromstring(MODEL.format(version=version, more=more).encode()), Version.FMI2)


def test_fmpys_reports_on_a_description_become_data():
    text = "The variable `n`{} is of type Integer and must have variability != `continuous`"
    assert description_breaches(model(), with_structure=False) == [
        DescriptionBreach(
            report=text.format(" (line 4)"),
            found=text.format(""),
            line=4,
            concerns_variability=True,
            kind="The variable   is of type Integer and must have variability != .",
            variable="n",
        )
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
    text = MODEL.format(version="2.0", more="")
    told = "Variable `y` (line 6) has declaredType=`T` which has not been defined"
    at_loss = "IndexError: list index out of range"  # which is better than no word at all
    for old, new, message in (("<Real/>", '<Real declaredType="T"/>', told), ('index="1"', 'index="7"', at_loss)):
        with pytest.raises(ModelDescriptionError) as error:
            read_model(etree.fromstring(text.replace(old, new).encode()), Version.FMI2)
        assert str(error.value) == message
    assert as_phrase('the "a"\n  of b.') == "the `a` of b"


def test_a_display_unit_without_a_unit_is_a_breach_and_stops_nothing():
    root = etree.fromstring(
        MODEL.format(version="2.0", more="").replace("<Real/>", '<Real displayUnit="km"/>').encode()
    )
    found = description_breaches(read_model(root, Version.FMI2), with_structure=True)
    assert [b.report for b in found if b.variable == "y"] == [
        "The display unit `km` of variable `y` (line 6) has no unit"
    ]


def test_the_names_of_many_variables_in_a_report_are_cut():
    found = breach_of("Expected {a, b, c, d, e} but was {}.")
    assert (found.report, found.kind) == ("Expected {a, b, c and 2 more} but was {}", "Expected  but was .")


def test_the_document_that_was_parsed_is_read_and_stays_as_it_is():
    text = MODEL.format(version="2.0.4", more="").replace(
        "<Real/>", "<Real/><Annotations>" + "x" * 11_000_000 + "</Annotations>"
    )
    text = text.replace('causality="output"><Real', 'causality="parameter" variability="constant"><Real')
    root = etree.fromstring(text.encode(), etree.XMLParser(huge_tree=True))
    found = read_model(root, Version.FMI2)
    assert [(v.name, v.initial) for v in found.modelVariables] == [("n", "calculated"), ("y", "exact")]
    assert root.get("fmiVersion") == "2.0.4"
    assert root.find("ModelVariables")[1].get("initial") is None


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
