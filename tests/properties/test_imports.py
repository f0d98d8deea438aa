"""The import rule of the design, read from the sources."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("components", "fmus", "orchestrator")
SOURCES = sorted(p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))


def imported(source: Path) -> set[str]:
    """All modules that a file imports, with the names taken from them, as dotted paths; relative ones resolved."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = list(source.relative_to(ROOT).parent.parts[: -node.level + 1 or None]) if node.level else []
            module = ".".join([*base, *filter(None, [node.module])])
            found |= {f"{module}.{alias.name}" for alias in node.names}
    return found


IMPORTS = {source.relative_to(ROOT).as_posix(): imported(source) for source in SOURCES}


def users(package: str, under: str = "") -> dict[str, set[str]]:
    """Files below a folder that import a package, with what they take from it."""
    return {
        name: taken
        for name, modules in IMPORTS.items()
        if name.startswith(under) and (taken := {m for m in modules if m == package or m.startswith(f"{package}.")})
    }


def test_the_sources_are_found():
    assert len(SOURCES) > 40
    assert users("components.interfaces", "fmus/")


def test_components_build_on_neither_fmus_nor_orchestrator():
    assert users("fmus", "components/") == {}
    assert users("orchestrator", "components/") == {}


def test_fmus_build_on_the_interfaces_only_and_not_on_the_catalogue():
    assert users("orchestrator", "fmus/") == {}
    for name, taken in users("components", "fmus/").items():
        assert all(f"{m}.".startswith("components.interfaces.") for m in taken), name


def test_the_orchestrator_takes_from_components_the_catalogue_and_the_interfaces_only():
    for name, taken in users("components", "orchestrator/").items():
        catalogue = {f"components.{name}" for name in ("BLOCKS", "EXTRAS", "add_block", "remove_block")}
        assert all(m.startswith("components.interfaces.") or m in catalogue for m in taken), (name, taken)


@pytest.mark.parametrize("folder", ["vehicle", "traffic", "controller"])
def test_no_sockets_folder_imports_another_and_the_interfaces_import_none(folder):
    for other in {"vehicle", "traffic", "controller", "interfaces"} - {folder}:
        assert users(f"components.{folder}", f"components/{other}/") == {}


@pytest.mark.parametrize(
    ("package", "allowed"),
    [
        ("fmpy", ("fmus/toolchain/fmpy_library.py",)),
        ("casadi", ("components/", "fmus/")),
        ("rerun", ("orchestrator/recording/",)),
    ],
)
def test_a_library_stays_where_it_belongs(package, allowed):
    found = users(package)
    assert found
    assert [name for name in found if not name.startswith(allowed)] == []
