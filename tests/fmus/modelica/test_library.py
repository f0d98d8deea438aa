"""The Modelica package MacroStep says what our interfaces say, and other tools can read it."""

from __future__ import annotations

import re

import pytest
import rumoca

from components.interfaces import buses
from components.interfaces.buses import (
    Actuation,
    Motion,
    ObstacleList,
    Plan,
    Solver,
    SolverStatus,
    Tyre,
    VehicleState,
    Waypoints,
)
from components.interfaces.record import variables
from components.interfaces.sockets import SOCKETS
from fmus.modelica.flat import library

ROOT = library()
FILES = sorted(ROOT.rglob("*.mo"))
KINDS = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "Enumeration": "SolverStatus"}
LENGTHS = {8: "slots", 15: "waypoints", 3: "N_p"}
RECORDS = (Actuation, VehicleState, Tyre, Motion, ObstacleList, Waypoints, Plan, Solver)
LINE = re.compile(
    r'  (?P<kind>\w+) (?P<name>\w+)(\[(?P<length>\w+)\])?(\((each )?unit = "(?P<unit>.+?)"\))? "(?P<text>.+)";'
)


@pytest.mark.parametrize("kind", RECORDS, ids=lambda kind: kind.__name__)
def test_every_bus_has_the_signals_units_and_words_of_ours(kind):
    text = (ROOT / "Interfaces" / f"{kind.__name__}.mo").read_text(encoding="utf-8")
    declared = [
        (m["name"], m["kind"], m["length"], m["unit"] or "1", m["text"])
        for m in map(LINE.fullmatch, text.splitlines())
        if m
    ]
    expected = [
        (v.name, KINDS[v.quantity.type], LENGTHS[v.size] if v.shape else None, v.quantity.unit, v.quantity.description)
        for v in variables(kind, {"N_p": 3})
    ]
    assert declared == expected


def test_lengths_and_enumerations_are_ours():
    package = (ROOT / "Interfaces" / "package.mo").read_text(encoding="utf-8")
    assert f"constant Integer slots = {buses.SLOTS} " in package
    assert f"constant Integer waypoints = {buses.WAYPOINTS} " in package
    items = re.findall(
        r'^    (\w+) "', (ROOT / "Interfaces" / "SolverStatus.mo").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert items == [item.name for item in SolverStatus]


@pytest.mark.parametrize("socket", SOCKETS.values(), ids=SOCKETS)
def test_every_socket_is_a_partial_block_with_our_buses(socket):
    text = (ROOT / "Interfaces" / f"{socket.name.capitalize()}.mo").read_text(encoding="utf-8")
    assert f"partial block {socket.name.capitalize()}" in text
    found = re.findall(r"^  (\w+)(Input|Output) (\w+) ", text, re.MULTILINE)
    assert found == [
        *((kind.__name__, "Input", name) for name, kind in socket.inputs.items()),
        *((kind.__name__, "Output", name) for name, kind in socket.outputs.items()),
    ]
    for name, kind in socket.optional.items():
        assert f"`{kind.__name__}Output {name}`" in text


@pytest.mark.parametrize("folder", sorted({path.parent for path in FILES}), ids=lambda f: f.name)
def test_the_order_of_every_package_names_all_of_its_classes(folder):
    inside = {p.stem for p in folder.glob("*.mo") if p.name != "package.mo"}
    inside |= {p.name for p in folder.iterdir() if p.is_dir()}
    listed = (folder / "package.order").read_text(encoding="utf-8").split()
    assert sorted(listed) == sorted(inside)


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_every_file_holds_one_class_of_its_name_within_its_package(path):
    text = path.read_text(encoding="utf-8")
    owner = path.parent if path.name != "package.mo" else path.parent.parent
    within = ".".join(owner.relative_to(ROOT.parent).parts)
    assert text.startswith(f"within {within};\n" if within else "within;\n")
    name = path.stem if path.name != "package.mo" else path.parent.name
    assert re.search(rf"^(partial )?(package|record|connector|type|block|model) {name}\b", text, re.MULTILINE)


def test_the_paper_bicycle_alone_moves_as_another_simulator_says():
    """rumoca's own solver, without our reading of the equations."""
    model = rumoca.Session([str(ROOT)]).load(str(ROOT / "Examples" / "Idle.mo"))
    last = model.simulate(t=(0, 2), dt=0.1)
    assert last["plant.state.x"][-1] == pytest.approx(20.0, rel=1e-6)
    assert last["plant.state.y"][-1] == pytest.approx(0.0, abs=1e-9)
    assert last["controller.ego.v_x"][-1] == pytest.approx(10.0, rel=1e-9)
