"""The annotation of this program: what it writes, and sockets of any number in it."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from components.interfaces.sockets import SOCKETS, add_socket
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from orchestrator.ssp.annotation import NO_ANNOTATION, annotation_of
from tests.fmus.foreign import entries
from tests.orchestrator.ssps import body, component, connectors, echo, vectors, write

PORTS = connectors("order.level:input:m", "y_order.level:output:m")


@record
class Order:
    """What a driver is told, and says again."""

    level: float = quantity("m", "level")


@pytest.fixture
def driver():
    """A fourth socket."""
    socket = Socket(name="driver", inputs={"order": Order}, outputs={"y_order": Order})
    add_socket(socket)
    yield socket
    del SOCKETS["driver"]


@pytest.fixture
def theirs(tmp_path):
    """An SSP of another maker, whose unit fits the fourth socket."""
    fmu = echo(tmp_path / "echo.fmu", [("order.level", "Real", "0", {"unit": "m"})])
    return write(tmp_path / "theirs.ssp", body(component("a", "echo.fmu", PORTS)), {"resources/echo.fmu": fmu})


def changed(path, **content):
    """An SSP of ours whose annotation says something else."""
    files = entries(path)
    text = files.pop("SystemStructure.ssd").decode()
    before, _, rest = text.partition('="urn:macrostep">')
    old, _, after = rest.partition("</")
    made = path.with_name("changed.ssp")
    write(made, f'{before}="urn:macrostep">{json.dumps(json.loads(old) | content)}</{after}', files)
    return made


def refusal(path):
    with pytest.raises(RequestError) as error:
        ssp_reader.read(path)
    return [str(problem).partition("SystemStructure.ssd, ")[2] or str(problem) for problem in error.value.problems]


def test_a_socket_that_was_added_is_found_written_and_read(driver, theirs, tmp_path):
    found = ssp_reader.read(theirs)
    assert found.system.sockets == {"a": driver}
    ssp.write(found, tmp_path / "ours.ssp")
    assert ssp_reader.read(tmp_path / "ours.ssp").system.sockets == {"a": driver}
    assert refusal(changed(tmp_path / "ours.ssp", sockets={"a": "drive", "b": 3})) == [
        "line 36: sockets.a: found `drive`; valid: 'plant', 'traffic', 'controller' or 'driver'",
        "line 36: sockets.b: found `3`; valid: 'plant', 'traffic', 'controller' or 'driver'",
    ]


def test_a_socket_that_nothing_knows_is_refused(theirs, tmp_path):
    found = ssp_reader.read(theirs)
    assert found.system.sockets == {}
    ssp.write(found, tmp_path / "ours.ssp")
    assert refusal(changed(tmp_path / "ours.ssp", sockets={"a": "driver"})) == [
        "line 36: sockets.a: found `driver`; valid: 'plant', 'traffic' or 'controller'"
    ]


def test_an_fmu_in_place_of_an_ssp_is_for_any_socket(driver, theirs, tmp_path):
    assert refusal(tmp_path / "echo.fmu")[0].endswith(
        "It is an FMU: give it with --plant, --traffic, --controller or --driver."
    )


def test_entries_stand_in_their_order_with_ratios_as_text_and_bytes_as_digits(tmp_path):
    path = write(
        tmp_path / "theirs.ssp",
        body(component("a", "vectors.fmu")),
        {"resources/vectors.fmu": vectors(tmp_path / "vectors.fmu")},
        version="2.0",
    )
    read = ssp_reader.read(path)
    made = replace(read, h=0.2, system=replace(read.system, steps={"a": Fraction(1, 2)}))
    assert json.loads(annotation_of(made)) == {
        "step": 0.2, "scene": None, "sockets": {}, "held": {"a.v": [1, 2, 3], "a.w": [5, 5], "a.s": 0, "a.b": "00ff"},
        "algorithm": "sequential", "solve_loops": False, "end_off_road": False,
        "tolerance": None, "record": {"*": 1}, "allow_nonfinite": [], "table": None, "table_holds": False,
        "steps": {"a": "1/2"}, "isolated": {}, "in_process": [], "through_step": {},
        "sources": {},
    }  # fmt: skip
    assert [*json.loads(annotation_of(made))] == [*type(NO_ANNOTATION).model_fields]
    ssp.write(made, tmp_path / "ours.ssp")
    again = ssp_reader.read(tmp_path / "ours.ssp").system
    assert (again.held["a.b"], again.steps) == (b"\x00\xff", {"a": Fraction(1, 2)})
    for wrong in ("0g", 7):
        held = {**json.loads(annotation_of(made))["held"], "a.b": wrong}
        assert refusal(changed(tmp_path / "ours.ssp", held=held)) == [
            f"held.a.b: found `{wrong}`; valid: hexadecimal digits, two for each byte"
        ]


def test_how_units_act_in_time_is_read_back_and_told(theirs, tmp_path):
    found = ssp_reader.read(theirs)
    unit = found.system.units["a"].acting_through_step(["y_order.level"])
    ssp.write(replace(found, system=replace(found.system, units={"a": unit})), tmp_path / "ours.ssp")
    again = ssp_reader.read(tmp_path / "ours.ssp")
    assert again.system.units["a"].through_step == {"y_order.level"}
    told = "a: y_order.level follow the inputs through a step only, as the file says, whatever the FMU declares"
    assert told in again.remarks
    ssp.write(again, tmp_path / "again.ssp")
    assert (tmp_path / "again.ssp").read_bytes() == (tmp_path / "ours.ssp").read_bytes()
    wrong = {"b": ["y"], "a": ["z"]}
    assert refusal(changed(tmp_path / "ours.ssp", through_step=wrong)) == [
        "through_step: b.y: found no such output; valid: a",
        "through_step: a.z: found no such output; valid: y_order.level",
    ]
