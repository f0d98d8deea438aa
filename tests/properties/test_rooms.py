"""Rooms: each folder of a package is a stage of the flow, and imports only from the stages before it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

ROOMS = {
    "components": ["interfaces", "vehicle", "traffic", "controller", "catalogue"],
    "fmus": ["clock", "unit_interface", "lowering", "toolchain", "export", "reading", "units", "modelica"],
    "orchestrator": [
        "system",
        "stepping",
        "mapping",
        "scenario",
        "ssp",
        "results",
        "loading",
        "pictures",
        "recording",
        "exchange",
        "viewing",
        "execution",
        "own_system",
        "sweeping",
        "reproduction",
        "command",
    ],
}
"""The rooms of each package, in the order in which data passes them; a name without a folder is a file."""

FOLDERS_OF_DATA = {"components/modelica", "orchestrator/scenarios", "fmus/runtime", "fmus/built"}


def arrows(package: str) -> set[tuple[str, str, str]]:
    """Room, room that it imports from, and the file that does so."""
    found: set[tuple[str, str, str]] = set()
    for path in sorted((ROOT / package).rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        if len(parts) == 2 and parts[1] == "__init__":  # the facade hands on what all rooms offer
            continue
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            modules: list[str] = []
            if isinstance(node, ast.ImportFrom) and node.module:
                modules = [f"{node.module}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            for module in modules:
                first, _, rest = module.partition(".")
                room = rest.partition(".")[0]
                if first == package and room and room != parts[1]:
                    found.add((parts[1], room, path.relative_to(ROOT).as_posix()))
    return found


@pytest.mark.parametrize("package", ROOMS)
def test_a_room_imports_only_from_rooms_before_it(package):
    order = ROOMS[package]
    found = arrows(package)
    assert found
    assert [arrow for arrow in sorted(found) if order.index(arrow[1]) > order.index(arrow[0])] == []


@pytest.mark.parametrize("package", ROOMS)
def test_every_room_has_its_place(package):
    files = {p.stem for p in (ROOT / package).glob("*.py") if p.stem != "__init__"}
    folders = {p.name for p in (ROOT / package).iterdir() if p.is_dir() and p.name != "__pycache__"}
    data = {name.partition("/")[2] for name in FOLDERS_OF_DATA if name.startswith(f"{package}/")}
    assert files | (folders - data) == set(ROOMS[package])
