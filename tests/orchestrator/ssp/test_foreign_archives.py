"""SSPs that are packed or written in unusual ways: a file twice, very long texts, integers that drive enumerations.

And those that mean harm: names that lead elsewhere, and systems that expand without end.

Shows `ssp/archive.py` and, of the reader, its remarks.
"""

from __future__ import annotations

import json
import zipfile

import pytest

from components.interfaces.problem import RequestError
from orchestrator.scenario.options import Options
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp.archive import Findings, open_package, read_document
from orchestrator.ssp.structure import read_structure
from orchestrator.ssp.vocabulary import DESCRIPTION_FILE
from orchestrator.stepping.whole_run import simulate
from tests.fmus.foreign import copied, entries
from tests.orchestrator.ssps import body, component, connectors, echo, ssd, wire, write

PORTS = connectors("u:input", "y_u:output")
GEAR = (
    '<SimpleType name="Gear"><Enumeration><Item name="neutral" value="0"/><Item name="first" value="1"/></Enumeration>'
    "</SimpleType>"
)


@pytest.fixture
def plain(tmp_path):
    return echo(tmp_path / "plain.fmu", ["u"], [("k", "Real", "3")])


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_file_that_is_packed_twice_is_told_once(tmp_path, plain):
    path = write(tmp_path / "s.ssp", body(component("a", "plain.fmu", PORTS)), {"resources/plain.fmu": plain})
    with zipfile.ZipFile(path, "a") as archive:
        archive.write(plain, "resources/plain.fmu")
    scenario = ssp_reader.read(path)
    assert "the archive has resources/plain.fmu more than once, with the same bytes" in scenario.remarks
    assert len(simulate(scenario.system, h=scenario.h, until=scenario.until)) == 4


def test_a_text_of_many_megabytes_is_passed_over(tmp_path, plain):
    long = f'<ssc:Annotation type="org.tool"><n xmlns="urn:n">{"x" * 11_000_000}</n></ssc:Annotation>'
    inside = body(component("a", "plain.fmu", PORTS), after=f"<ssd:Annotations>{long}</ssd:Annotations>")
    scenario = ssp_reader.read(write(tmp_path / "s.ssp", inside, {"resources/plain.fmu": plain}))
    assert len(simulate(scenario.system, h=scenario.h, until=scenario.until)) == 4


def test_an_integer_may_drive_an_enumeration_and_a_remark_says_so(tmp_path):
    gives = echo(tmp_path / "gives.fmu", [("u", "Integer", "1")])
    takes = echo(tmp_path / "takes.fmu", [("e", "Enumeration", "1", {"declaredType": "Gear"})], types=GEAR)
    inside = body(
        component("a", "gives.fmu", connectors("y_u:output", kind="Integer"))
        + component(
            "b",
            "takes.fmu",
            '<ssd:Connectors><ssd:Connector name="e" kind="input"><ssc:Enumeration name="Gear"/></ssd:Connector>'
            "</ssd:Connectors>",
        ),
        wire("a.y_u", "b.e"),
    )
    items = '<ssd:Enumerations><ssc:Enumeration name="Gear"><ssc:Item name="neutral" value="0"/>'
    items += '<ssc:Item name="first" value="1"/></ssc:Enumeration></ssd:Enumerations>'
    path = write(
        tmp_path / "s.ssp",
        inside,
        {"resources/gives.fmu": gives, "resources/takes.fmu": takes},
        units=False,
        end=f'{items}<ssd:DefaultExperiment stopTime="0.3"/>',
    )
    scenario = ssp_reader.read(path)
    assert (
        "a.y_u -> b.e: an integer drives an enumeration; every value is passed on, also one that is not in"
        " 0 (neutral), 1 (first)" in scenario.remarks
    )
    rows = simulate(scenario.system, h=scenario.h, until=scenario.until)
    assert rows["b.y_e"].tolist()[-1] == 1


def included(kind, source):
    return component("p", source, attributes=f'type="application/x-ssp-{kind}"')


def refusal(path):
    with pytest.raises(RequestError) as error:
        ssp_reader.read(path)
    return str(error.value).replace(f"{path.parent}/", "")


def test_a_system_that_is_used_again_and_again_has_a_limit(tmp_path, plain):
    path = tmp_path / "s0.ssp"
    write(path, body(component("a", "plain.fmu", PORTS)), {"resources/plain.fmu": plain})
    for level in range(1, 6):
        used = "".join(included("package", "i.ssp").replace('"p"', f'"p{k}"') for k in range(10))
        path = write(tmp_path / f"s{level}.ssp", body(used), {"resources/i.ssp": path})
    assert refusal(path).endswith(
        ": found an SSP that becomes more than 1000 systems from other places; valid: at most 1000. What is taken"
        " ten times"
        " into what is taken ten times is there a hundred times."
    )


def test_a_package_that_is_used_twice_is_unpacked_once(tmp_path, plain):
    inner = write(tmp_path / "i.ssp", body(component("a", "plain.fmu", PORTS)), {"resources/plain.fmu": plain})
    used = included("package", "i.ssp") + included("package", "i.ssp").replace('"p"', '"q"')
    findings = Findings()
    package = open_package(write(tmp_path / "s.ssp", body(used), {"resources/i.ssp": inner}), "s.ssp", findings)
    document = read_document(package, package.folder / DESCRIPTION_FILE)
    root = read_structure(document)
    assert [*root.elements] == ["p", "q"]
    assert (findings.problems, len(findings.expansion.packages), findings.expansion.systems) == ([], 2, 2)


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("http://[", "the address `http://[`"),
        ("a" * 300, f"`resources/{'a' * 70}... (310 characters)`, which has a part of more than 255 bytes"),
        ("a/" * 600, f"`resources/{'a/' * 35}... (1210 characters)`, which has more than 1000 characters"),
        ("a%00b", "`resources/a%00b`, which has control characters"),
        ("../../x", "`resources/../../x`, which leaves the archive"),
    ],
)
def test_sources_that_no_file_has(tmp_path, source, found):
    whole = body(component("a", source, PORTS)) if source != "http://[" else body(component("a", "X", PORTS))
    text = ssd(whole).replace("resources/X", source)
    path = write(tmp_path / "s.ssp", text)
    with pytest.raises(RequestError) as error:
        ssp_reader.read(path, options=Options(lenient=True))
    assert f"component `a`: found {found}; valid: the relative path of a file in the archive" in str(error.value)


def test_the_part_of_a_package_that_leads_out_of_it_is_not_there(tmp_path, plain):
    inner = write(tmp_path / "i.ssp", body(component("a", "plain.fmu", PORTS)), {"resources/plain.fmu": plain})
    (tmp_path / "secret.ssd").write_text(ssd(""))
    path = write(tmp_path / "s.ssp", body(included("package", "i.ssp#../../secret.ssd")), {"resources/i.ssp": inner})
    assert "i.ssp#../../secret.ssd: found no ../../secret.ssd; valid: an SSP" in refusal(path)


def test_a_wrong_guid_names_the_fmu_in_the_ssp(tmp_path):
    fmu = echo(tmp_path / "plain.fmu", ["u"])
    text = entries(fmu)["modelDescription.xml"].replace(b'guid="g"', b'guid="other"')
    fmu = copied(fmu, tmp_path / "wrong.fmu", {"modelDescription.xml": text})
    path = write(tmp_path / "s.ssp", body(component("a", "wrong.fmu", PORTS)), {"resources/wrong.fmu": fmu})
    scenario = ssp_reader.read(path)
    with pytest.raises(RequestError) as error:
        simulate(scenario.system, h=scenario.h, until=scenario.until)
    assert str(error.value).startswith(
        f"{path}, resources/wrong.fmu: found a library that refuses to make an instance ("
    )


@pytest.mark.parametrize("ratio", ["1e999999999", "1/0/1", "9" * 5000, "x"])
def test_a_ratio_with_which_one_could_compute_for_ever_is_refused(tmp_path, plain, ratio):
    text = json.dumps({"step": 0.1, "sockets": {}, "steps": {"a": ratio}})
    note = f'<m:Scenario xmlns:m="urn:macrostep">{text}</m:Scenario>'
    end = '<ssd:DefaultExperiment stopTime="1"/><ssd:Annotations><ssc:Annotation type="org.macrostep">'
    whole = ssd(body(component("a", "plain.fmu", PORTS)), end=f"{end}{note}</ssc:Annotation></ssd:Annotations>")
    path = write(tmp_path / "s.ssp", whole, {"resources/plain.fmu": plain})
    assert refusal(path).startswith(f"s.ssp, SystemStructure.ssd, line 12: steps.a: found `{ratio[:40]}")


def test_an_annotation_that_is_nested_without_end_is_refused(tmp_path, plain):
    note = f'<m:Scenario xmlns:m="urn:macrostep">{"[" * 100_000}</m:Scenario>'
    end = '<ssd:DefaultExperiment stopTime="1"/><ssd:Annotations><ssc:Annotation type="org.macrostep">'
    whole = ssd(body(component("a", "plain.fmu", PORTS)), end=f"{end}{note}</ssc:Annotation></ssd:Annotations>")
    path = write(tmp_path / "s.ssp", whole, {"resources/plain.fmu": plain})
    assert "line 12: found an annotation that is no JSON (maximum recursion depth exceeded" in refusal(path)


def test_names_in_a_file_of_ours_that_lead_elsewhere_are_changed(tmp_path, plain):
    text = json.dumps({"step": 0.1, "sockets": {}})
    note = f'<m:Scenario xmlns:m="urn:macrostep">{text}</m:Scenario>'
    end = '<ssd:DefaultExperiment stopTime="1"/><ssd:Annotations><ssc:Annotation type="org.macrostep">'
    whole = ssd(body(component("../../x", "plain.fmu", PORTS)), end=f"{end}{note}</ssc:Annotation></ssd:Annotations>")
    whole = whole.replace('name="theirs"', 'name="../x"')
    scenario = ssp_reader.read(write(tmp_path / "s.ssp", whole, {"resources/plain.fmu": plain}))
    assert (scenario.name, [*scenario.system.units]) == ("x", ["______x"])
