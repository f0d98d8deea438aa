"""SSPs of other makers: structure and experiment become a system that runs like one built by hand, or in FMPy.

This shows `reader.py`, `structure.py`, `system_elements.py`, `connection_graph.py`, `assembly.py` and
`default_experiment.py`.
"""

from __future__ import annotations

import re

import fmpy.ssp.simulation
import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssv

from components.interfaces.problem import RequestError
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.scenario.resolution import Setting
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import C, description3, entries, library, pack
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


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """An FMU with an input u and a parameter k, both shown after a step."""
    return echo(tmp_path_factory.mktemp("fmus") / "plain.fmu", ["u"], [("k", "Real", "3")])


def run(scenario, **changed):
    return simulate(scenario.system, h=scenario.h, until=scenario.until, **changed)


def nested(path, plain, extra=""):
    """Systems in systems: a gives, through two levels and straight through one."""
    inner = system(
        "inner",
        component("c", "plain.fmu", PORTS),
        wire("x", "c.u") + wire("c.y_u", "z"),
        connectors("x:input", "z:output"),
    )
    outer = system(
        "outer",
        inner + component("d", "plain.fmu", PORTS),
        wire("i", "inner.x") + wire("inner.z", "d.u") + wire("d.y_u", "o") + extra,
        connectors("i:input", "o:output", "through:output"),
    )
    a = component("a", "plain.fmu", connectors("k:parameter", "y_k:output", "u:input"))
    wires = wire("a.y_k", "outer.i") + wire("outer.o", "a.u") + wire("outer.through" if extra else "a.y_k", "b.u")
    whole = body(outer + a + component("b", "plain.fmu", PORTS), wires)
    return write(path, whole, {"resources/plain.fmu": plain})


def test_systems_in_systems_run_like_the_same_system_built_by_hand(plain, tmp_path):
    path = nested(tmp_path / "theirs.ssp", plain, wire("through", "i"))
    read = ssp_reader.read(path, {"a": [Setting("a", "k=3.0")]})
    wiring = {"outer_inner_c.u": "a.y_k", "outer_d.u": "outer_inner_c.y_u", "a.u": "outer_d.y_u", "b.u": "a.y_k"}
    assert {c.target: c.origin for c in read.system.connections} == wiring
    units = {name: Fmu(plain, {"k": 3.0} if name == "a" else {}) for name in ("outer_inner_c", "outer_d", "a", "b")}
    found, expected = run(read), simulate(System(units, wiring), h=0.1, until=0.3)
    assert found.equals(expected[found.columns])
    assert found["b.y_u"].tolist()[-1] == 3.0
    assert (read.name, read.title, read.h, read.until, read.scene) == ("theirs", "theirs", 0.1, 0.3, None)
    assert read.remarks == (
        "units: `outer_inner_c` is `outer.inner.c`, `outer_d` is `outer.d`",
        "the SSP says no macro step: 0.1 s is used; --step changes it",
    )


def test_a_connection_leads_from_output_to_input_whichever_is_its_start(plain, tmp_path):
    """The schema of SSP: start and end "do not denote directionality"."""
    elements = component("a", "plain.fmu", PORTS) + component("b", "plain.fmu", PORTS)
    whole = body(elements, wire("b.u", "a.y_u"))
    found = ssp_reader.read(write(tmp_path / "theirs.ssp", whole, {"resources/plain.fmu": plain}))
    assert [str(c) for c in found.system.connections] == ["a.y_u -> b.u"]


def test_fmpy_gets_the_same_numbers_from_systems_in_systems(plain, tmp_path):
    path = nested(tmp_path / "theirs.ssp", plain)
    (tmp_path / "set.ssv").write_text(values(**{"a.k": 3}))
    theirs = fmpy.ssp.simulation.simulate_ssp(
        path, stop_time=0.6, step_size=0.1, parameter_set=read_ssv(tmp_path / "set.ssv")
    )
    ours = ssp_reader.read(path, {"a": [Setting("a", "k=3.0")]}, options=Options(stop_time=0.6))
    found = run(ours, algorithm="jacobi")
    names = {"outer.inner.c": "outer_inner_c", "outer.d": "outer_d", "b": "b"}
    for name, unit in names.items():  # FMPy writes the row of t_k after its step
        assert np.array_equal(theirs[f"{name}.y_u"][:6], found[f"{unit}.y_u"].to_numpy()[1:7]), name
    assert found["outer_d.y_u"].iloc[-1] == 3.0


def test_what_was_read_from_another_maker_is_written_and_read_again(plain, tmp_path):
    theirs = nested(tmp_path / "a.ssp", plain, wire("i", "through"))
    read = ssp_reader.read(theirs, {"a": [Setting("a", "k=3.0")]})
    ssp.write(read, tmp_path / "b.ssp")
    again = ssp_reader.read(tmp_path / "b.ssp")
    assert run(again).equals(run(read))
    assert (again.name, again.title, again.h, again.until) == (read.name, read.title, read.h, read.until)
    ssp.write(again, tmp_path / "c.ssp")
    assert (tmp_path / "b.ssp").read_bytes() == (tmp_path / "c.ssp").read_bytes()


def test_units_of_any_name_have_paths_that_end_at_their_dot(plain, tmp_path):
    inner = system("B", component("C", "plain.fmu", PORTS))
    whole = body(inner + component("B.C", "plain.fmu", PORTS) + component("my unit", "plain.fmu", PORTS))
    read = ssp_reader.read(write(tmp_path / "a.ssp", whole, {"resources/plain.fmu": plain}))
    assert list(read.system.units) == ["B_C", "B_C_2", "my_unit"]
    assert read.remarks[:2] == (
        "units: `B_C` is `B.C`, `B_C_2` is `B.C`, `my_unit` is `my unit`",
        "inputs that nothing drives keep their start values: B_C.u = 0.0, B_C_2.u = 0.0, my_unit.u = 0.0",
    )


@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=lambda v: f"fmi{v}")
def test_a_system_of_ours_without_our_annotation_fills_the_sockets_all_the_same(version, built_fmus, tmp_path):
    ours = prepare("static", Options(mode=version, stop_time=0.5))
    ssp.write(ours, tmp_path / "ours.ssp")
    files = entries(tmp_path / "ours.ssp")
    text = files.pop("SystemStructure.ssd").decode()
    ours_only = r"<ssd:Annotations>\s*<ssc:Annotation type=\"org.macrostep\">.*?</ssd:Annotations>"
    text = re.sub(ours_only, "", text, flags=re.DOTALL)
    theirs = ssp_reader.read(write(tmp_path / "theirs.ssp", text, files))
    assert {name: socket.name for name, socket in theirs.system.sockets.items()} == {
        "plant": "plant", "traffic": "traffic", "controller": "controller"
    }  # fmt: skip
    assert (theirs.scene, theirs.h, theirs.until, theirs.remarks) == (None, 0.1, 0.5, ())
    assert run(theirs).equals(run(ours))


@pytest.mark.parametrize(
    ("end", "h", "remark"),
    [
        ('<ssd:DefaultExperiment stopTime="1"/>', 0.1, "the SSP says no macro step: 0.1 s is used; --step changes it"),
        (
            '<ssd:DefaultExperiment stopTime="1"><ssd:Annotations><ssc:Annotation type="com.opensimulationplatform">'
            '<o:Algorithm xmlns:o="http://opensimulationplatform.com/SSP/OSPAnnotations">'
            '<o:FixedStepAlgorithm baseStepSize="0.25"/></o:Algorithm></ssc:Annotation></ssd:Annotations>'
            "</ssd:DefaultExperiment>",
            0.25,
            None,
        ),
        (
            '<ssd:DefaultExperiment stopTime="1"/><ssd:Annotations><ssc:Annotation type="org.openmodelica">'
            '<o:SimulationInformation xmlns:o="https://raw.githubusercontent.com/OpenModelica/oms">'
            '<o:FixedStepMaster stepSize="0.5"/></o:SimulationInformation></ssc:Annotation></ssd:Annotations>',
            0.5,
            None,
        ),
    ],
)
def test_the_macro_step_is_what_annotations_hint_at(plain, tmp_path, end, h, remark):
    whole = body(component("a", "plain.fmu", PORTS))
    read = ssp_reader.read(write(tmp_path / "a.ssp", whole, {"resources/plain.fmu": plain}, end=end))
    assert read.h == h
    assert (remark in read.remarks) is (remark is not None)
    assert ssp_reader.read(tmp_path / "a.ssp", options=Options(step=0.2)).h == 0.2


def test_a_component_may_have_a_step_of_its_own(plain, tmp_path):
    hint = (
        '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><o:StepSizeHint value="0.2"'
        ' xmlns:o="http://opensimulationplatform.com/SSP/OSPAnnotations"/></ssc:Annotation></ssd:Annotations>'
    )
    whole = body(component("a", "plain.fmu", PORTS + hint))
    read = ssp_reader.read(write(tmp_path / "a.ssp", whole, {"resources/plain.fmu": plain}))
    assert read.system.steps == {"a": 2}


def nested_package(tmp_path, plain, kind, source, files, outer=""):
    reference = (
        f'<ssd:Component name="sub" type="application/x-ssp-{kind}" source="{source}">'
        f"{connectors('i:input', 'o:output')}{outer}</ssd:Component>"
    )
    whole = body(reference + component("a", "plain.fmu", PORTS), wire("a.y_u", "sub.i") + wire("sub.o", "a.u"))
    return write(tmp_path / "outer.ssp", whole, {"resources/plain.fmu": plain, **files})


def inner_description(value):
    ports = connectors("u:input", "y_u:output", "y_k:output")
    inside = connectors("i:input", "o:output") + bindings(binding(values(**{"b.k": value})))
    return ssd(inside + body(component("b", "plain.fmu", ports), wire("i", "b.u") + wire("b.y_k", "o")))


def test_a_component_may_be_a_package_or_a_description_of_its_own(plain, tmp_path):
    write(tmp_path / "sub.ssp", inner_description(4), {"resources/plain.fmu": plain, "Other.ssd": inner_description(5)})
    package = {"resources/sub.ssp": tmp_path / "sub.ssp"}
    cases = [
        ("package", "resources/sub.ssp", package, 4.0),
        ("package", "resources/sub.ssp#Other.ssd", package, 5.0),
        ("definition", "Sub.ssd", {"Sub.ssd": inner_description(6)}, 6.0),
    ]
    for kind, source, files, k in cases:
        read = ssp_reader.read(nested_package(tmp_path, plain, kind, source, files))
        assert {str(c) for c in read.system.connections} == {"a.y_u -> sub_b.u", "sub_b.y_k -> a.u"}
        assert read.system.units["sub_b"].parameters == {"k": k}
        assert run(read)["a.y_u"].iloc[-1] == k
    outer = bindings(binding(values(**{"b.k": 9})))  # bindings of the component count more than those of its system
    read = ssp_reader.read(nested_package(tmp_path, plain, "package", "resources/sub.ssp", package, outer))
    assert read.system.units["sub_b"].parameters == {"k": 9.0}


def test_a_system_may_be_used_again_by_its_id(plain, tmp_path):
    first = system("one", component("c", "plain.fmu", PORTS)).replace("<ssd:System ", '<ssd:System id="it" ')
    again = '<ssd:Component name="two" type="application/x-ssp-definition" source="#it"/>'
    read = ssp_reader.read(write(tmp_path / "a.ssp", body(first + again), {"resources/plain.fmu": plain}))
    assert list(read.system.units) == ["one_c", "two_c"]


def test_signals_of_a_dictionary_lead_from_where_they_are_written_to_where_they_are_read(plain, tmp_path):
    def reference(name):
        port = '<ssd:Connectors><ssd:Connector name="s" kind="inout"><ssc:Real/></ssd:Connector></ssd:Connectors>'
        return f'<ssd:SignalDictionaryReference name="{name}" dictionary="bus">{port}</ssd:SignalDictionaryReference>'

    inner = system("inner", component("c", "plain.fmu", PORTS) + reference("here"), wire("here.s", "c.u"))
    a = component("a", "plain.fmu", connectors("y_k:output"))
    entry = '<ssb:DictionaryEntry name="s"><ssc:Real/></ssb:DictionaryEntry>'
    content = f'<ssb:SignalDictionary {SPACES} version="1.0">{entry}</ssb:SignalDictionary>'
    for source, files in (('source="resources/bus.ssb"', {"resources/bus.ssb": content}), ("", {})):
        given = f'<ssd:SignalDictionary name="bus" {source}>{"" if files else content}</ssd:SignalDictionary>'
        dictionary = f"<ssd:SignalDictionaries>{given}</ssd:SignalDictionaries>"
        whole = body(inner + a + reference("there"), wire("a.y_k", "there.s"), dictionary)
        read = ssp_reader.read(write(tmp_path / "a.ssp", whole, {"resources/plain.fmu": plain, **files}))
        assert [str(c) for c in read.system.connections] == ["a.y_k -> inner_c.u"]


def test_arrays_of_fmi_3_are_connected_whole_and_by_element_and_through_systems(tmp_path):
    fmu = vectors(tmp_path / "vectors.fmu")
    size = '<ssc:Dimension size="3"/>'
    ports = (
        "<ssd:Connectors>"
        + "".join(
            f'<ssd:Connector name="{n}" kind="{k}"><ssc:Float64/>{size if "v" in n else ""}</ssd:Connector>'
            for n, k in (("v", "input"), ("y_v", "output"), ("s", "input"), ("y_s", "output"))
        )
        + "</ssd:Connectors>"
    )
    inner = system(
        "inner",
        component("c", "vectors.fmu", ports),
        wire("i", "c.v") + wire("c.y_v", "o"),
        f'<ssd:Connectors><ssd:Connector name="i" kind="input"><ssc:Float64/>{size}</ssd:Connector>'
        f'<ssd:Connector name="o" kind="output"><ssc:Float64/>{size}</ssd:Connector></ssd:Connectors>',
    )
    elements = inner + component("a", "vectors.fmu", ports) + component("b", "vectors.fmu", ports)
    wires = (
        wire("a.y_v", "inner.i")
        + wire("inner.o", "b.v", attributes='startIndices="3" endIndices="1"')
        + wire("a.y_s", "b.v", attributes='endIndices="2"')
        + wire("b.y_v", "a.s", attributes='startIndices="1"')
    )
    path = write(tmp_path / "a.ssp", body(elements, wires), {"resources/vectors.fmu": fmu}, version="2.0")
    read = ssp_reader.read(path, options=Options(stop_time=0.6))
    assert [str(c) for c in read.system.connections] == [
        "a.y_v -> inner_c.v", "b.y_v[1] -> a.s", "inner_c.y_v[3] -> b.v[1]", "a.y_s -> b.v[2]"
    ]  # fmt: skip
    assert read.system.held["b.v"] == [1.0, 2.0, 3.0]
    assert read.system.held["a.b"] == b"\x00\xff"
    row = run(read).iloc[-1]
    assert [row[f"b.y_v[{i}]"] for i in (1, 2, 3)] == [3.0, 3.0, 3.0]
    assert row["a.y_s"] == 3.0
    ssp.write(read, tmp_path / "b.ssp")
    again = ssp_reader.read(tmp_path / "b.ssp")
    assert run(again).equals(run(read))
    assert again.system.held == read.system.held


def test_an_array_may_be_empty(tmp_path):
    whole = body(component("a", "vectors.fmu", connectors("s:input")))
    path = write(tmp_path / "theirs.ssp", whole, {"resources/vectors.fmu": vectors(tmp_path / "vectors.fmu")})
    read = ssp_reader.read(path, {"a": [Setting("a", "n=0")]})
    assert {v.name: v.shape for v in read.system.units["a"].interface.inputs} == {
        "v": (3,),
        "w": (0,),
        "s": (),
        "b": (),
    }
    assert list(run(read)["a.y_v[3]"]) == [0.0, 3.0, 3.0, 3.0]


def test_a_whole_array_may_be_driven_through_a_system_element_by_element(tmp_path):
    fmu = vectors(tmp_path / "vectors.fmu")
    size = '<ssc:Dimension size="3"/>'

    def port(name, kind, inside=size):
        return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Float64/>{inside}</ssd:Connector>'

    inner = system(
        "inner",
        component("c", "vectors.fmu", f"<ssd:Connectors>{port('v', 'input')}</ssd:Connectors>"),
        wire("i", "c.v"),
        f"<ssd:Connectors>{port('i', 'input')}</ssd:Connectors>",
    )
    ports = port("y_v", "output") + port("y_s", "output", "")
    a = component("a", "vectors.fmu", f"<ssd:Connectors>{ports}</ssd:Connectors>")
    wires = wire("a.y_v", "inner.i", attributes='startIndices="2" endIndices="3"')
    wires += wire("a.y_s", "inner.i", attributes='endIndices="1"')
    path = write(tmp_path / "a.ssp", body(inner + a, wires), {"resources/vectors.fmu": fmu}, version="2.0")
    read = ssp_reader.read(path)
    assert [str(c) for c in read.system.connections] == ["a.y_s -> inner_c.v[1]", "a.y_v[2] -> inner_c.v[3]"]


def test_elements_of_fmi_2_are_connected_one_by_one_and_make_a_whole_where_they_are_one(tmp_path):
    names = [f"x[{i}]" for i in (1, 2, 3)]
    fmu = echo(tmp_path / "x.fmu", names)
    text = connectors(*[f"{n}:input" for n in names], *[f"y_{n}:output" for n in names])
    elements = "".join(component(name, "x.fmu", text) for name in ("a", "b", "c"))
    wires = "".join(wire(f"a.y_{n}", f"b.{n}") for n in names)
    wires += wire("a.y_x[3]", "c.x[1]") + wire("b.y_x[1]", "c.x[2]")
    read = ssp_reader.read(write(tmp_path / "a.ssp", body(elements, wires), {"resources/x.fmu": fmu}))
    assert [str(c) for c in read.system.connections] == [
        "a.y_x -> b.x", "a.y_x[3] -> c.x[1]", "b.y_x[1] -> c.x[2]"
    ]  # fmt: skip
    ssp.write(read, tmp_path / "b.ssp")
    again = ssp_reader.read(tmp_path / "b.ssp").system
    assert [str(c) for c in again.connections] == [str(c) for c in read.system.connections]


def test_settings_reach_units_of_any_name_and_unknown_ones_are_refused(plain, tmp_path):
    path = write(tmp_path / "a.ssp", body(component("a", "plain.fmu", PORTS)), {"resources/plain.fmu": plain})
    with pytest.raises(RequestError) as error:
        ssp_reader.read(path, {"b": [Setting("b", "k=1.0")], "a": [Setting("a", "q=1.0")]})
    assert str(error.value).splitlines() == [
        "a.q: found an unknown parameter; valid: k, u",
        "--set b.k: found the unknown unit `b`; valid: a",
    ]


def test_a_system_read_is_stepped_like_any_other(plain, tmp_path):
    path = write(tmp_path / "a.ssp", body(component("a", "plain.fmu", PORTS)), {"resources/plain.fmu": plain})
    read = ssp_reader.read(path, options=Options(stop_time=0.2))
    with Simulation(read.system, h=read.h, until=read.until) as simulation:
        simulation.write("a.u", 7.0)
        simulation.run()
        assert simulation.read("a.y_u") == 7.0


def test_ticks_of_clocks_are_handed_on_as_the_connections_say(tmp_path):
    clocks = [
        '<Clock name="beat" valueReference="15" causality="output" intervalVariability="triggered"/>',
        '<Clock name="triggered" valueReference="14" causality="input" intervalVariability="triggered"/>',
        '<Clock name="constant" valueReference="10" causality="input" intervalVariability="constant"'
        ' intervalDecimal="0.25" shiftDecimal="0.05"/>',
        '<Clock name="fixed" valueReference="11" causality="input" intervalVariability="fixed"/>',
        '<Int32 name="n" valueReference="24" causality="output"/>',
    ]
    structure = ['<Output valueReference="15" dependencies=""/>', '<Output valueReference="24" dependencies=""/>']
    interface = '<CoSimulation modelIdentifier="m" hasEventMode="true" canReturnEarlyAfterIntermediateUpdate="true"/>'
    text = description3(clocks, structure, interface=interface)
    binary = library(tmp_path / "made", Version.FMI3, (C / "clocked.c").read_text())
    fmu = pack(tmp_path / "clocked.fmu", Version.FMI3, text, binary)
    ports = (
        '<ssd:Connectors><ssd:Connector name="beat" kind="output"><ssc:Clock/></ssd:Connector>'
        '<ssd:Connector name="triggered" kind="input"><ssc:Clock/></ssd:Connector></ssd:Connectors>'
    )
    inner = system(
        "inner",
        component("b", "clocked.fmu", ports),
        wire("tick", "b.triggered"),
        '<ssd:Connectors><ssd:Connector name="tick" kind="input"><ssc:Clock/></ssd:Connector></ssd:Connectors>',
    )
    whole = body(inner + component("a", "clocked.fmu", ports), wire("a.beat", "inner.tick"))
    path = write(tmp_path / "theirs.ssp", whole, {"resources/clocked.fmu": fmu}, version="2.0")
    read = ssp_reader.read(path, options=Options(stop_time=1.0))
    assert [str(c) for c in read.system.clock_connections] == ["a.beat -> inner_b.triggered"]
    ssp.write(read, tmp_path / "again.ssp")
    for scenario in (read, ssp_reader.read(tmp_path / "again.ssp")):
        frame = run(scenario, algorithm="clocked")
        assert frame["a.n"].iloc[-1] == 0
        assert frame["inner_b.n"].iloc[-1] == 4  # 0.05, 0.3, 0.55 and 0.8 s
