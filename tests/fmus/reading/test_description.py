"""Model descriptions that break rules: refused with the line, or read all the same by a lenient reader, who says so."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.reading.declared_variables import declared_variables
from fmus.reading.description import read_description
from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, scalar

GOOD2 = description2(
    [scalar("u", 1, "input", of_start="0"), scalar("y", 2, "output")],
    ['<Unknown index="2" dependencies="1"/>'],
    initial=['<Unknown index="2"/>'],
)
Y = '<Float64 name="y" valueReference="1" causality="output"/>'
GOOD3 = description3([Y], ['<Output valueReference="1"/>', '<InitialUnknown valueReference="1"/>'])


def read(text, *, lenient=False):
    return read_description(text.encode(), "m.fmu", lenient=lenient)


def refused(text, *, lenient=False):
    with pytest.raises(RequestError) as error:
        read(text, lenient=lenient)
    return str(error.value).splitlines()


REMEDY = "Have the file corrected by its maker, or run it as it is with --lenient."
ALLOWED = f"valid: what FMI 2.0 allows. {REMEDY}"


def test_good_descriptions_are_read_without_a_remark():
    assert (read(GOOD2).version, read(GOOD2).remarks) == (Version.FMI2, ())
    assert (read(GOOD3).version, read(GOOD3).remarks) == (Version.FMI3, ())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "<fmi>\n<a>\n</fmi>",
            "m.fmu, modelDescription.xml, line 3: found XML that is not well-formed"
            " (Opening and ending tag mismatch: a line 2 and fmi)",
        ),
        (
            '<!DOCTYPE a [<!ENTITY x "y">]><a>&x;</a>',
            "m.fmu, modelDescription.xml: found a document type declaration (DTD), whose entities could expand",
        ),
        ("<html/>", "m.fmu, modelDescription.xml: found a description of no FMU (its root is `html`)"),
        (
            '<fmiModelDescription fmiVersion="4.0"/>',
            "m.fmu, modelDescription.xml: found FMI version 4.0; valid: 1.0, 2.0 or 3.0."
            " Export it again as FMI 2.0 or 3.0.",
        ),
        (
            GOOD3.replace("CoSimulation", "ScheduledExecution"),
            "m.fmu, modelDescription.xml: found only Scheduled Execution; valid: Co-Simulation or Model Exchange."
            " Export it again for Co-Simulation or Model Exchange.",
        ),
        (
            GOOD3.replace('<CoSimulation modelIdentifier="m"/>', ""),
            "m.fmu, modelDescription.xml: found no interface type; valid: Co-Simulation or Model Exchange."
            " Export it again for Co-Simulation or Model Exchange.",
        ),
    ],
)
def test_what_nobody_can_read_is_refused_also_by_a_lenient_reader(text, message):
    assert refused(text)[0].startswith(message)
    assert refused(text, lenient=True)[0].startswith(message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            GOOD2.replace('index="2" dependencies="1"', 'index="7" dependencies="1 9"'),
            [
                "line 9: found `index` of Unknown, variable number 7, which is not there",
                "line 9: found `dependencies` of Unknown, variable number 9, which is not there",
            ],
        ),
        (  # twice on one line, told once
            GOOD2.replace('index="2" dependencies="1"', 'index="2" dependencies="9 9"'),
            ["line 9: found `dependencies` of Unknown, variable number 9, which is not there"],
        ),
        (
            GOOD3.replace('<Output valueReference="1"/>', '<Output valueReference="1" dependencies="5"/>'),
            ["line 10: found `dependencies` of Output, value reference 5, which is not there"],
        ),
        (
            GOOD3.replace(Y, Y.replace("/>", '><Dimension valueReference="8"/></Float64>')),
            ["line 7: found `valueReference` of Dimension, value reference 8, which is not there"],
        ),
        (
            GOOD3.replace(Y, Y.replace("/>", ' declaredType="T" derivative="4"/>')),
            [
                "line 7: found `derivative` of Float64, value reference 4, which is not there",
                "line 7: found the declared type `T`, which is not there",
            ],
        ),
    ],
)
def test_references_to_what_is_not_there_are_refused_with_their_lines(text, message):
    expected = [f"m.fmu, modelDescription.xml, {m}; valid: what the file declares" for m in message]
    assert refused(text) == expected
    assert refused(text, lenient=True) == expected


def test_variables_without_a_name_or_a_value_reference_are_refused():
    text = GOOD3.replace('name="y" valueReference="1" ', "")
    found = refused(text, lenient=True)
    assert found[:2] == [
        "m.fmu, modelDescription.xml, line 7: found a variable without `name`;"
        " valid: a name of its own for each variable",
        "m.fmu, modelDescription.xml, line 7: found a variable without `valueReference`;"
        " valid: a name of its own for each variable",
    ]


@pytest.mark.parametrize(
    ("text", "message", "version"),
    [
        (
            GOOD2.replace('<Real start="0"/>', '<Real start="abc"/>'),
            "modelDescription.xml, line 6: found Element 'Real', attribute 'start': 'abc' is not a valid value",
            2,
        ),
        (
            GOOD2.replace('<Real start="0"/>', '<Real start="0" unit="km"/>'),
            "modelDescription.xml, line 6: found The unit `km` of variable `u` is not defined",
            2,
        ),
        (
            GOOD3.replace(Y, Y + Y.replace('"y"', '"z"')),
            "modelDescription.xml, line 7: found Variable `z` has the same value reference as variable `y` (line 7)",
            3,
        ),
        (
            GOOD3.replace("instantiationToken", "guid"),
            "modelDescription.xml, line 2: found Element 'fmiModelDescription', attribute 'guid'",
            3,
        ),
        (
            GOOD2.replace('fmiVersion="2.0"', 'fmiVersion="2.0.4"'),
            "modelDescription.xml: found FMI version 2.0.4; valid: 1.0, 2.0 or 3.0",
            None,
        ),
    ],
)
def test_broken_rules_are_refused_and_overlooked_by_a_lenient_reader(text, message, version):
    found = refused(text)
    assert found[0].startswith(f"m.fmu, {message}")
    assert found[0].endswith(REMEDY)
    if version:
        assert f"; valid: what FMI {version}.0 allows. " in found[0]


@pytest.mark.parametrize(
    ("text", "remark"),
    [
        (
            GOOD2.replace('<Real start="0"/>', '<Real start="0" unit="km"/>'),
            "modelDescription.xml: The unit `km` of variable `u` (line 6) is not defined",
        ),
        (
            GOOD2.replace('guid="g" ', 'guid="g" maker="me"'),
            "modelDescription.xml, line 2: Element 'fmiModelDescription', attribute 'maker':"
            " The attribute 'maker' is not allowed.",
        ),
        (
            GOOD2.replace('fmiVersion="2.0"', 'fmiVersion="2.0.4"'),
            "modelDescription.xml: FMI version 2.0.4, read as 2.0",
        ),
    ],
)
def test_a_lenient_reader_says_what_is_broken(text, remark):
    assert remark in read(text, lenient=True).remarks


def test_names_that_stand_for_two_variables_are_refused_by_everybody():
    text = GOOD2.replace('name="y"', 'name="u"')
    assert refused(text, lenient=True) == [
        "m.fmu, modelDescription.xml, line 7: found two variables with the name `u`;"
        " valid: a name of its own for each variable"
    ]


def test_what_most_tools_accept_is_said_but_not_refused():
    without = GOOD2.replace('<InitialUnknowns><Unknown index="2"/></InitialUnknowns>', "")
    assert read(without).remarks == (
        "modelDescription.xml: ModelStructure/InitialUnknowns does not contain the expected set of variables."
        " Expected {y} but was {}",
    )
    assert read(GOOD3.replace('<Output valueReference="1"/>', "")).remarks == (
        "modelDescription.xml: ModelStructure/Outputs must have exactly one entry for each variable with"
        " causality=`output`",
    )


def test_breaches_of_one_kind_are_told_once_by_a_lenient_reader():
    variables = [scalar(f"u{i}", i, "input") for i in range(12)]
    text = description2(variables).replace("<Real />", '<Real speed="1"/>')
    assert read(text, lenient=True).remarks == (
        "modelDescription.xml, line 6: Element 'Real', attribute 'speed': The attribute 'speed' is not allowed."
        " (the same 11 more times, in line 7, 8, 9 and 8 more)",
        "modelDescription.xml: Variable `u0` (line 6) has no start value (the same of `u1`, `u2`, `u3` and 8 more)",
    )


def test_a_parameter_that_is_constant_is_refused_and_left_alone_by_a_lenient_reader():
    text = GOOD2.replace('causality="input"', 'causality="parameter" variability="constant"')
    found = "The combination causality=`parameter` and variability=`constant` in variable `u`{} is not allowed"
    assert refused(text) == [f"m.fmu, modelDescription.xml, line 6: found {found.format('')}; {ALLOWED}"]
    lenient = read(text, lenient=True)
    assert f"modelDescription.xml: {found.format(' (line 6)')}" in lenient.remarks
    declared = declared_variables(lenient.root, lenient.model, Version.FMI2, {})
    assert [v.variable.name for v in declared] == ["y"]


def test_what_python_raises_on_a_broken_description_is_told():
    assert refused(GOOD2.replace('valueReference="1"', 'valueReference="x"'), lenient=True) == [
        "m.fmu, modelDescription.xml: found a description that cannot be understood (ValueError: invalid literal for"
        " int() with base 10: 'x'); valid: what FMI allows. Open it without --lenient, to see the rules that it breaks."
    ]


def test_a_start_value_that_is_as_long_as_an_array_is_read():
    long = Y.replace(
        "/>", f' initial="exact" start="{"0.1234567 " * 1_200_000}"><Dimension start="1200000"/></Float64>'
    )
    assert len(read(GOOD3.replace(Y, long)).model.modelVariables[1].start) > 10_000_000


def test_integers_without_a_variability_are_said_but_not_refused():
    text = GOOD2.replace('<Real start="0"/>', '<Integer start="0"/>')
    assert read(text).remarks == (
        "modelDescription.xml: The variable `u` (line 6) is of type Integer and must have variability != `continuous`",
    )


def test_lists_may_be_spaced_as_xml_allows():
    spaced = GOOD2.replace('dependencies="1"', 'dependencies=" 1\n  1 "')
    assert [v.name for v in read(spaced).model.outputs[0].dependencies] == ["u", "u"]


def test_later_versions_are_read_as_version_3_0():
    assert read(GOOD3.replace('fmiVersion="3.0"', 'fmiVersion="3.1"')).remarks == (
        "modelDescription.xml: FMI version 3.1, read as 3.0",
    )


def test_long_lists_of_problems_are_cut():
    text = description2([scalar(f"u{i}", i, "input", of_start="x") for i in range(60)])
    assert len(refused(text)) == 20
