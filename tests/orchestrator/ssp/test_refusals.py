"""What of an SSP cannot be run is refused by name, with its file and line, all of it at once, before anything runs.

This shows what `archive.py`, `rules.py`, `types.py`, `connections.py`, `ssp_units.py` and `connection_graph.py` refuse.
"""

from __future__ import annotations

import contextlib
import json
import random
import re
import zipfile
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from components.interfaces.problem import RequestError
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.scenario.resolution import Setting
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp_writer
from tests.orchestrator.ssps import (
    SPACES,
    binding,
    bindings,
    body,
    component,
    connectors,
    echo,
    ssd,
    system,
    values,
    vectors,
    wire,
    write,
)

PORTS = connectors("u:input", "y_u:output")
A, B = component("a", "plain.fmu", PORTS), component("b", "plain.fmu", PORTS)
KINDS = "an output to an input, a parameter to a parameter, and through connectors of the system of the same kind"
STEP_SIZE_HINT = (
    '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:StepSizeHint value="0.2"'
    ' xmlns:osp="http://opensimulationplatform.com/SSP/OSPAnnotations"/></ssc:Annotation></ssd:Annotations>'
)
LENIENT = ". Have the file corrected by its maker, or read it as it is with --lenient."


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    plain = echo(
        folder / "plain.fmu",
        [("u", "Real", "0", {"unit": "m"})],
        [("k", "Real", "3", {"unit": "m"}), ("n", "Integer", "0")],
    )
    return {"resources/plain.fmu": plain}


def refusal(path, settings=None, **options):
    """The messages, from the file in the archive on."""
    with pytest.raises(RequestError) as error:
        ssp_reader.read(path, settings, Options(**options))
    return [re.sub(r"^.*?theirs\.ssp(, SystemStructure\.ssd)?(, |: )", "", str(p)) for p in error.value.problems]


def read(tmp_path, files, whole, options=None, **changed):
    return refusal(write(tmp_path / "theirs.ssp", whole, files, **changed), **(options or {}))


def test_archives_that_are_no_ssp(tmp_path, files):
    valid = "valid: an SSP: a zip archive with SystemStructure.ssd, SSP 1.0 or 2.0"
    path = tmp_path / "theirs.ssp"
    assert refusal(path) == [f"found no such file; {valid}"]
    path.write_text("hello")
    assert refusal(path) == [f"found a file that is no zip archive; {valid}"]
    path.write_bytes(files["resources/plain.fmu"].read_bytes())
    assert refusal(path) == [
        f"found an archive without SystemStructure.ssd; {valid}."
        " It is an FMU: give it with --plant, --traffic or --controller."
    ]

    def holding(name):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(name, "x")
        return refusal(path)

    assert holding("readme.txt") == [f"found an archive without SystemStructure.ssd; {valid}"]
    for name in ("../evil.txt", "/evil.txt", "a\\..\\..\\evil.txt"):
        assert holding(name) == [f"found an entry that would leave the folder, {name}; {valid}"]
    assert not list(tmp_path.parent.rglob("evil.txt"))


def test_descriptions_that_cannot_be_read(tmp_path):
    root = "`SystemStructureDescription` of SSP 1.0 or 2.0"
    xml = "valid: well-formed XML without a DTD"
    cases = {
        '<?xml version="1.0"?><a': (
            f"line 1: found XML that is not well-formed (Couldn't find end of Start Tag a line 1); {xml}"
        ),
        '<?xml version="1.0"?>\n<a>\n<b></a>': (
            f"line 3: found XML that is not well-formed (Opening and ending tag mismatch: b line 3 and a); {xml}"
        ),
        '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>': (
            f"found a document type declaration (DTD), whose entities could expand without end; {xml}"
        ),
        '<?xml version="1.0"?>\n<a/>': f"line 2: found the element `a`; valid: {root}",
        '<?xml version="1.0"?><d:SystemStructureDescription xmlns:d="http://www.pmsf.net/xsd/Draft"/>': (
            f"line 1: found the element `{{http://www.pmsf.net/xsd/Draft}}SystemStructureDescription`; valid: {root}"
        ),
        ssd("").replace('version="1.0" name', 'version="3.0" name'): "line 2: found SSP version 3.0; valid: 1.0 or 2.0",
    }
    for text, expected in cases.items():
        assert read(tmp_path, {}, text) == [expected]


def test_breaches_of_the_schema_are_told_with_their_line_and_a_lenient_reader_only_tells(tmp_path, files):
    whole = body(A + B, wire("a.y_u", "b.u")).replace('kind="input"', 'kind="input" colour="red"', 1)
    said = "Element 'Connector', attribute 'colour': The attribute 'colour' is not allowed"
    assert read(tmp_path, files, whole) == [f"line 6: found {said}; valid: what SSP 1.0 allows{LENIENT}"]
    found = ssp_reader.read(tmp_path / "theirs.ssp", options=Options(lenient=True))
    assert [str(c) for c in found.system.connections] == ["a.y_u -> b.u"]
    assert found.remarks[0].endswith(f"SystemStructure.ssd, line 6: {said}; valid: what SSP 1.0 allows")


def test_ssp_2_is_measured_by_its_elements(tmp_path, files):
    whole = body(A + B).replace("<ssd:Connectors>", "<ssd:Connectors><ssd:Plug/>", 1)
    whole = whole.replace(' name="b"', "")
    assert read(tmp_path, files, whole, version="2.0") == [
        f"line 6: found `Plug` inside `Connectors`, which takes Annotations, Connector, MetaData, Signature;"
        f" valid: what SSP 2.0 allows{LENIENT}",
        f"line 7: found `Component` without the attribute `name`; valid: what SSP 2.0 allows{LENIENT}",
    ]


def test_connections_to_nowhere(tmp_path, files):
    wires = wire("a.y_u", "c.u") + wire("a.y", "b.u") + wire("i", "b.u") + wire("a.u", "b.u") + wire("a.y_u", "b.y_u")
    valid = f"valid: {KINDS}"
    assert read(tmp_path, files, body(A + B, wires)) == [
        "line 12: a.y_u -> c.u: found no element `c`; valid: a, b",
        "line 13: a.y -> b.u: found no connector `y` of `a`; valid: u, y_u",
        "line 14: i -> b.u: found no connector `i` of the system; valid: nothing",
        f"line 15: a.u -> b.u: found a connection of an input and an input; {valid}",
        f"line 16: a.y_u -> b.y_u: found a connection of an output and an output; {valid}",
    ]  # fmt: skip


def test_two_sources(tmp_path, files):
    c = component("c", "plain.fmu", PORTS)
    inner = system("inner", c, wire("i", "c.u"), connectors("i:input"))
    wires = wire("a.y_u", "b.u") + wire("b.y_u", "b.u") + wire("a.y_u", "inner.i") + wire("b.y_u", "inner.i")
    path = write(tmp_path / "theirs.ssp", body(A + B + inner, wires), files)
    where = f"{path}, SystemStructure.ssd, line"
    assert read(tmp_path, files, body(A + B + inner, wires)) == [
        f"line 22: b.y_u -> b.u: found a second source of `b.u`; valid: one source, as in {where} 21: a.y_u -> b.u",
        "line 24: b.y_u -> inner.i: found a second source of the connector `i`;"
        f" valid: one source, as in {where} 23: a.y_u -> inner.i",
    ]


def test_connections_in_a_circle(tmp_path, files):
    def through(name):
        return system(name, component("c", "plain.fmu", PORTS), wire("i", "o"), connectors("i:input", "o:output"))

    inner = system("x", A, wire("i", "a.u") + wire("i", "o"), connectors("i:input", "o:output"))
    wires = wire("x.o", "y.i") + wire("y.o", "x.i")
    assert read(tmp_path, files, body(inner + through("y"), wires)) == [
        "line 13: i -> o: found connections in a circle; valid: a way from a unit to a unit"
    ]


def test_wrong_types_and_units_of_another_dimension(tmp_path, files):
    seconds = connectors("u:input:s", "y_u:output", "n:parameter", "k:input")
    assert read(tmp_path, files, body(component("a", "plain.fmu", seconds))) == [
        f"line 6: found `u` in `s`; valid: `m`, as `m` says{LENIENT}",
        f"line 6: found `n` of type Float64 in `1`; valid: Int32 in `1`, as `m` says{LENIENT}",
        f"line 6: found the kind `input` of `k`; valid: `parameter`, as `m` says{LENIENT}",
    ]
    inner = system("inner", B, wire("i", "b.u"), connectors("i:input:s"))
    assert read(tmp_path, files, body(A + inner, wire("a.y_u", "inner.i"))) == [
        "line 19: a.y_u -> inner.i: found the unit `m`; valid: a unit that measures the same as `s`"
    ]
    numbers = component("b", "plain.fmu", connectors("y_n:output", kind="Integer"))
    change = '<ssc:LinearTransformation factor="2"/>'
    assert read(tmp_path, files, body(A + numbers, wire("b.y_n", "a.u", change))) == [
        "line 12: b.y_n -> a.u: found a linear transformation of Int32 in `1`; valid: one of a Float64 or Float32"
    ]


def test_connectors_that_the_unit_does_not_have(tmp_path, files):
    whole = body(component("a", "plain.fmu", connectors("y:output", "u:input")) + B, wire("a.y", "b.u"))
    assert read(tmp_path, files, whole) == [
        "line 6: found the connector `y`, of which `m` has no variable; valid: k, n, u, y_k, y_n, y_u",
        "line 12: a.y -> b.u: found no variable `y` of `a`; valid: one that it has",
    ]


def test_parameters_that_only_a_run_gives(tmp_path, files):
    reader = component("b", "plain.fmu", connectors("k:parameter"))
    assert read(tmp_path, files, body(A + reader, wire("a.y_u", "b.k"))) == [
        f"line 12: a.y_u -> b.k: found a connection of an output and a parameter; valid: {KINDS}"
    ]
    giver = component("a", "plain.fmu", connectors("y_u:calculatedParameter"))
    found = read(tmp_path, files, body(giver + reader, wire("a.y_u", "b.k")))
    assert found == [
        f"line 6: found the kind `calculatedParameter` of `y_u`; valid: `output`, as `m` says{LENIENT}",
        "line 12: a.y_u -> b.k: found `a.y_u` for the parameter `k`; valid: a value that is known before anything runs",
    ]


def test_components_that_cannot_be_used(tmp_path, files):
    broken = {**files, "resources/broken.fmu": "hello"}
    whole = body(
        component("a", "none.fmu")
        + component("b", "broken.fmu")
        + '<ssd:Component name="c" type="application/x-modelica" source="resources/plain.fmu"/>\n'
        + '<ssd:Component name="d" source="http://localhost/a.fmu"/>\n'
        + '<ssd:Component name="e" source="../a.fmu"/>\n'
        + '<ssd:Component name="f" source=""/>\n'
        + component("g", "plain.fmu", attributes='implementation="ModelExchange"')
        + component("g", "plain.fmu")
    )
    path = "valid: the relative path of a file in the archive"
    assert read(tmp_path, broken, whole) == [
        f"line 5: component `a`: found the file `resources/none.fmu`, which is not there; {path}."
        " Did you mean `resources/broken.fmu`?",
        "line 9: component `c`: found the type `application/x-modelica`;"
        " valid: application/x-fmu-sharedlibrary, application/x-ssp-definition, application/x-ssp-package",
        f"line 10: component `d`: found the address `http://localhost/a.fmu`; {path}. Put the file into the archive.",
        f"line 11: component `e`: found `../a.fmu`, which leaves the archive; {path}",
        "line 12: component `f`: found no source; valid: the path of an FMU or SSP in the archive. Give it one.",
        "line 15: found a second element `g`; valid: names of their own",
        "line 7: component `b`, broken.fmu: found a file that is no zip archive; valid: an FMU: a zip archive with"
        " modelDescription.xml, FMI 1.0, 2.0 or 3.0, for Co-Simulation or Model Exchange",
        "line 13: component `g`, plain.fmu: found no ModelExchange; valid: CoSimulation."
        " Export it with both, or choose what it has.",
    ]


def included(kind, source):
    return body(f'<ssd:Component name="sub" type="application/x-ssp-{kind}" source="{source}"/>')


def test_an_ssp_that_includes_itself(tmp_path, files):
    found = read(tmp_path, files, included("definition", "SystemStructure.ssd"))
    assert found == [
        "line 5: component `sub`: found an SSP that includes itself: SystemStructure.ssd -> SystemStructure.ssd;"
        " valid: systems without a circle"
    ]
    other = ssd(included("definition", "SystemStructure.ssd"))
    found = read(tmp_path, {**files, "Other.ssd": other}, included("definition", "Other.ssd"))
    assert found == [
        "Other.ssd, line 5: component `sub`: found an SSP that includes itself:"
        " SystemStructure.ssd -> Other.ssd -> SystemStructure.ssd; valid: systems without a circle"
    ]
    again = system("one", '<ssd:Component name="two" type="application/x-ssp-definition" source="#it"/>')
    found = read(tmp_path, files, body(again.replace("<ssd:System ", '<ssd:System id="it" ')))
    assert found == [
        "line 7: component `two`: found an SSP that includes itself: SystemStructure.ssd -> #it -> #it;"
        " valid: systems without a circle"
    ]


def test_packages_and_descriptions_that_are_not_there(tmp_path, files):
    empty = tmp_path / "empty.ssp"
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("readme.txt", "x")
    files = {**files, "resources/empty.ssp": empty, "resources/text.ssp": "x"}
    assert read(tmp_path, files, included("package", "resources/empty.ssp")) == [
        "resources/empty.ssp: found no SystemStructure.ssd; valid: an SSP: a zip archive with SystemStructure.ssd"
    ]
    assert read(tmp_path, files, included("package", "resources/text.ssp")) == [
        "resources/text.ssp: found a file that is no zip archive;"
        " valid: an SSP: a zip archive with SystemStructure.ssd, SSP 1.0 or 2.0"
    ]
    assert read(tmp_path, files, included("definition", "#none")) == [
        "line 5: component `sub`: found the system `#none`, which is not there; valid: the id of a system"
    ]
    reference = '<ssd:SignalDictionaryReference name="r" dictionary="bus"/>'
    assert read(tmp_path, files, body(reference)) == ["line 5: r: found the signal dictionary `bus`; valid: nothing"]


def test_parameter_values_that_do_not_fit(tmp_path, files):
    made = values(k=("Real", 3, "s"), n=("Real", 1.5, None), u=("Boolean", "true", None), y_u=1)
    found = read(tmp_path, files, body(component("a", "plain.fmu", bindings(binding(made)))))
    line = "line 6: parameter"
    assert found == [
        f"{line} `k`: found the unit `s`; valid: a unit that measures the same as `m`",
        f"{line} `n`: found a value of type Real; valid: Int32",
        f"{line} `y_u`: found a value of `a.y_u`, which the unit says is not to be set;"
        " valid: values of parameters, inputs and start values",
        f"{line} `u`: found a value of type Boolean; valid: Float64",
    ]
    made = values(n=("Integer", "many", None), k=("Real", "INF", None))
    found = read(tmp_path, files, body(component("a", "plain.fmu", bindings(binding(made)))))
    assert found == [
        "line 6: found Element 'Integer', attribute 'value': 'many' is not a valid value of the atomic type 'xs:int';"
        f" valid: what SSP 1.0 allows{LENIENT}",
        f"{line} `n`: found `many`; valid: whole number",
        f"{line} `k`: found inf; valid: finite number [m]",
    ]


def test_parameter_bindings_that_cannot_be_used(tmp_path, files):
    mapped = (
        f'<ssd:ParameterMapping><ssm:ParameterMapping {SPACES} version="1.0">'
        '<ssm:MappingEntry source="a" target="k"/><ssm:MappingEntry source="b" target="k"/>'
        '<ssm:MappingEntry source="c" target="k"/></ssm:ParameterMapping></ssd:ParameterMapping>'
    )
    inside = bindings(
        binding(values(k=1), 'type="text/csv"'),
        binding(),
        binding("", 'source="resources/none.ssv"'),
        binding("", 'source="resources/bad.ssv"'),
        binding(values(k=1), mapping='<ssd:ParameterMapping type="text/csv"/>'),
        binding(values(a=1, b=2), mapping=mapped),
        binding("", 'source="own.ssv" sourceBase="component"'),
    )
    path = "valid: the relative path of a file in the archive"
    found = read(tmp_path, {**files, "resources/bad.ssv": "<a>\n"}, body(component("a", "plain.fmu", inside)))
    assert found == [
        "line 6: parameter binding: found the type `text/csv`; valid: application/x-ssp-parameter-set",
        "line 6: ParameterBinding: found neither a source nor a content; valid: one of them, a `ParameterSet`",
        f"line 6: ParameterBinding: found the file `resources/none.ssv`, which is not there; {path}."
        " Did you mean `resources/bad.ssv`?",
        "resources/bad.ssv, line 2: found XML that is not well-formed (Premature end of data in tag a line 1);"
        " valid: well-formed XML without a DTD",
        "line 6: parameter mapping: found the type `text/csv`; valid: application/x-ssp-parameter-mapping",
        "line 6: b -> k: found a second value for `k`; valid: one entry for each target",
        "line 6: c -> k: found no value `c`; valid: a, b",
        "line 6: ParameterBinding: found the file `own.ssv`, which is not in the component; valid: a file inside it",
    ]


def test_parameter_sets_inside_components_that_are_no_archives(tmp_path, files):
    inside = bindings(binding("", 'source="own.ssv" sourceBase="component"'))
    definition = 'source="inner.ssd" type="application/x-ssp-definition"'
    whole = body(component("a", "bad.fmu", inside) + f'<ssd:Component name="b" {definition}>{inside}</ssd:Component>')
    archive = "ParameterBinding: found a file that is no zip archive; valid: a component that is a zip archive"
    assert read(tmp_path, {"resources/bad.fmu": "no archive", "inner.ssd": ssd("")}, whole) == [
        "line 5: component `a`, bad.fmu: found a file that is no zip archive; valid: an FMU: a zip archive with"
        " modelDescription.xml, FMI 1.0, 2.0 or 3.0, for Co-Simulation or Model Exchange",
        f"line 6: {archive}",
        f"line 7: {archive}",
    ]


def test_experiments_that_cannot_be_run(tmp_path, files):
    assert read(tmp_path, files, body(A), end="") == [
        "line 2: found no stop time; valid: a number of seconds. Say how long with --stop-time."
    ]
    assert ssp_reader.read(tmp_path / "theirs.ssp", options=Options(stop_time=1.0)).until == 1.0
    hasty = body(component("a", "plain.fmu", PORTS + STEP_SIZE_HINT))
    assert read(tmp_path, files, hasty, options={"step": 0.0}) == [
        "step: found 0 s; valid: a positive number of seconds"
    ]
    assert read(tmp_path, files, body(A), end='<ssd:DefaultExperiment stopTime="soon"/>') == [
        "line 12: found Element 'DefaultExperiment', attribute 'stopTime': 'soon' is not a valid value of the atomic"
        f" type 'xs:double'; valid: what SSP 1.0 allows{LENIENT}",
        "line 12: `stopTime` of `DefaultExperiment`: found `soon`; valid: a finite number",
        "line 12: found no stop time; valid: a number of seconds. Say how long with --stop-time.",
    ]


def test_transformations_that_mean_nothing(tmp_path, files):
    twice = '<ssc:MapEntry source="1" target="2"/><ssc:MapEntry source="1" target="3"/>'
    table = f"<ssc:IntegerMappingTransformation>{twice}</ssc:IntegerMappingTransformation>"
    numbers = connectors("y_n:output", kind="Integer")
    b = component("b", "plain.fmu", numbers)
    assert read(tmp_path, files, body(A + b, wire("b.y_n", "a.u", table))) == [
        "line 12: IntegerMappingTransformation: found two entries for `1`; valid: one entry for each value",
        "line 12: b.y_n -> a.u: found Int32 in `1`; valid: Float64 in `m`",
    ]


@pytest.mark.parametrize("kind", ["Cubic", "BooleanCubic"])
def test_transformations_that_the_standard_does_not_have(tmp_path, files, kind):
    cubic = f"<ssc:{kind}Transformation/>"
    assert read(tmp_path, files, body(A + B, wire("a.y_u", "b.u", cubic)), version="2.0") == [
        f"line 12: found `{kind}Transformation` inside `Connection`, which takes Annotations,"
        " BooleanMappingTransformation, ConnectionGeometry, EnumerationMappingTransformation,"
        " IntegerMappingTransformation, LinearTransformation, MetaData, Signature;"
        f" valid: what SSP 2.0 allows{LENIENT}",
        f"line 12: found the transformation `{kind}Transformation`; valid: one of SSP 1.0 or 2.0",
    ]


def test_indices_that_no_array_has(tmp_path, files):
    wires = wire("a.y_u", "b.u", attributes='endIndices="1"') + wire("b.y_u", "a.u", attributes='startIndices="0"')
    assert read(tmp_path, files, body(A + B, wires), version="2.0") == [
        "line 13: b.y_u -> a.u: found `0` in `startIndices`;"
        " valid: one whole number for each dimension, counted from 1",
        "line 12: a.y_u -> b.u: found the element 1 of `u`; valid: no element: it is a scalar",
    ]


def test_a_lenient_reader_uses_variables_that_no_connector_lists(tmp_path, files):
    bare = component("a", "plain.fmu") + component("b", "plain.fmu")
    wires = wire("a.y_u", "b.u")
    found = read(tmp_path, files, body(bare, wires))
    assert found == ["line 12: a.y_u -> b.u: found no connector `y_u` of `a`; valid: nothing",
                     "line 12: a.y_u -> b.u: found no connector `u` of `b`; valid: nothing"]  # fmt: skip
    lenient = ssp_reader.read(tmp_path / "theirs.ssp", options=Options(lenient=True))
    assert [str(c) for c in lenient.system.connections] == ["a.y_u -> b.u"]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("step", "an annotation that is no JSON (Expecting value: line 1 column 1 (char 0))"),
        ("[1]", "an annotation without a step or sockets"),
        ("{}", "an annotation without a step or sockets"),
    ],
)
def test_annotations_of_ours_that_were_changed(tmp_path, files, text, found):
    note = f'<m:Scenario xmlns:m="urn:macrostep">{text}</m:Scenario>'
    end = '<ssd:DefaultExperiment stopTime="1"/><ssd:Annotations><ssc:Annotation type="org.macrostep">'
    end += f"{note}</ssc:Annotation></ssd:Annotations>"
    assert read(tmp_path, files, body(A), end=end) == [f"line 12: found {found}; valid: what macrostep wrote"]


@pytest.mark.parametrize(
    ("note", "found"),
    [
        ({"step": -1}, ["line 12: step: found `-1`; valid: greater than 0"]),
        ({"sockets": {"b": "plant"}}, ["socket `plant`: found the unknown unit `b`; valid: a"]),
        (
            {"sockets": {"a": "plan"}, "isolated": {"a": 0}, "mood": "good"},
            [
                "line 12: sockets.a: found `plan`; valid: 'plant', 'traffic' or 'controller'",
                "line 12: isolated.a: found `0`; valid: greater than 0",
                "line 12: mood: found an unknown entry; valid: algorithm, allow_nonfinite, end_off_road, held,"
                " in_process, isolated, record, scene, sockets, solve_loops, sources, step, steps, table, table_holds,"
                " through_step, tolerance",
            ],
        ),
        (
            {"scene": dict.fromkeys(("ego_length", "ego_width", "l_gap", "y_left", "y_right", "y_lane", "trees"), 1.0)},
            [
                "scene.trees: found an unknown parameter; valid: ego_length, ego_width, l_gap, y_adjacent, y_lane,"
                " y_left, y_right, y_third",
                "scene.y_adjacent: found no value; valid: a number",
            ],
        ),
    ],
)
def test_annotations_of_ours_that_say_what_cannot_be(tmp_path, files, note, found):
    text = json.dumps({"step": 0.1, "sockets": {}, **note})
    end = '<ssd:DefaultExperiment stopTime="1"/><ssd:Annotations><ssc:Annotation type="org.macrostep">'
    end += f'<m:Scenario xmlns:m="urn:macrostep">{text}</m:Scenario></ssc:Annotation></ssd:Annotations>'
    assert read(tmp_path, files, body(A), end=end) == found


def test_a_unit_that_is_none_of_its_base_unit_is_no_other(tmp_path, files):
    u_km = component("b", "plain.fmu", connectors("u:input:km"))
    whole = ssd(body(A + u_km, wire("a.y_u", "b.u"))).replace('factor="1000"', 'factor="0"')
    told = "found `u` in `km`; valid: `m`, as `m` says"
    assert read(tmp_path, files, whole) == [f"line 8: {told}{LENIENT}"]


@pytest.mark.parametrize(
    ("indices", "size", "found"),
    [
        ("4", 3, ["line 12: x -> a.u: found the element 4 of `x`; valid: an element of 3"]),
        ("1 1", 3, ["line 12: x -> a.u: found the element 1 1 of `x`; valid: an element of 3"]),
        ("2", 10**400, ["line 6: parameter `x`: found 0 values; valid: 1, the length of `u`"]),
    ],
)
def test_elements_of_a_connector_of_the_system_that_it_does_not_have(tmp_path, files, indices, size, found):
    kind = f'kind="input"><ssc:Float64/><ssc:Dimension size="{size}"/>'
    array = f'<ssd:Connectors>\n<ssd:Connector name="x" {kind}</ssd:Connector></ssd:Connectors>\n'
    given = binding(values(x=("Float64", "1 2 3", None)).replace('version="1.0"', 'version="2.0"'))
    whole = array + bindings(given) + body(A, wire("x", "a.u", attributes=f'startIndices="{indices}"'))
    assert read(tmp_path, files, whole, version="2.0")[: len(found)] == found


def test_lengths_of_arrays_that_cannot_be_are_told_with_the_component(tmp_path):
    whole = body(component("a", "vectors.fmu", connectors("s:input")))
    path = write(tmp_path / "theirs.ssp", whole, {"resources/vectors.fmu": vectors(tmp_path / "vectors.fmu")})
    many = {"a": [Setting("a", "n=1000000000000")], "b": [Setting("b", "k=1")]}
    assert refusal(path, settings=many) == [
        "line 5: component `a`, vectors.fmu, modelDescription.xml, line 9: found a variable that cannot be understood"
        " (`w` with 1000000000000 elements, more than 10000000); valid: what FMI allows",
        "--set b.k: found the unknown unit `b`; valid: a",
    ]


def test_settings_of_the_scene_and_of_units_are_told_together(tmp_path):
    ssp_writer.write(prepare("static", Options(mode="blocks")), tmp_path / "theirs.ssp")
    wrong = {
        "scene": [Setting("scene", "ego_width=-1.0"), Setting("scene", "ego_widht=3")],
        "plant": [Setting("plant", "m=-2.0")],
    }
    assert refusal(tmp_path / "theirs.ssp", settings=wrong) == [
        "plant.m: found -2.0; valid: 1 <= finite number [kg]",
        "scene.ego_widht: found an unknown parameter; valid: ego_length, ego_width, l_gap, y_adjacent, y_lane, y_left,"
        " y_right, y_third. Did you mean `ego_width`?",
        "scene.ego_width: found -1.0; valid: 0 <= finite number [m]",
    ]


def test_a_name_that_would_leave_the_folder_of_runs_is_none(tmp_path):
    """It names the run folder; an SSP that says it is ours may come from anywhere."""
    made = prepare("static", Options(mode="blocks"))
    for name, kept in (("../../evil", "evil"), ("..", "system"), ("my static.2", "my static.2")):
        ssp_writer.write(replace(made, name=name), tmp_path / "theirs.ssp")
        assert ssp_reader.read(tmp_path / "theirs.ssp").name == kept


@given(seed=st.integers(0, 2**32), lenient=st.booleans())
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_description_that_was_damaged_is_refused_or_read(tmp_path, files, seed, lenient):
    """Whatever an attribute says, and whichever line is missing or doubled: a message, never a traceback."""
    chance = random.Random(seed)  # noqa: S311 - a test
    inside = bindings(binding(values(k=4, n=("Integer", 3, None))))
    inner = system("inner", B, wire("i", "b.u") + wire("b.y_u", "o"), connectors("i:input:km", "o:output"))
    change = '<ssc:LinearTransformation factor="2" offset="1"/>'
    a = component("a", "plain.fmu", connectors("k:parameter", "u:input", "y_u:output") + inside)
    whole = body(a + inner, wire("a.y_u", "inner.i", change) + wire("inner.o", "a.u"))
    text = ssd(whole, version=chance.choice(["1.0", "2.0"]))
    if chance.random() < 0.6:
        parts = text.split('"')
        found = ["", "nope", "-1", "1 2", "nan", "a.b", "1e400", "true", "input", "output", "inner", "../x", "9" * 30]
        parts[chance.randrange(1, len(parts), 2)] = chance.choice(found)
        text = '"'.join(parts)
    else:
        lines = text.splitlines()
        at = chance.randrange(1, len(lines))
        lines[at : at + 1] = chance.choice([[], [lines[at]] * 2])
        text = "\n".join(lines)
    path = write(tmp_path / "theirs.ssp", text if "<?xml" in text else f"<?xml{text}", files)
    with contextlib.suppress(RequestError):
        ssp_reader.read(path, options=Options(lenient=lenient))
