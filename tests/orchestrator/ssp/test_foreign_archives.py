"""SSPs that are packed or written in unusual ways: a file twice, very long texts, integers that drive enumerations.

Shows `ssp/archive.py` and, of the reader, its remarks.
"""

from __future__ import annotations

import zipfile

import pytest

from orchestrator.ssp import reader as ssp_reader
from orchestrator.stepping.whole_run import simulate
from tests.orchestrator.ssps import body, component, connectors, echo, wire, write

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
