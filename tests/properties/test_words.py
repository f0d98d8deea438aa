"""One word, one thing: a public class or constant stands in one module, and so does a file's name in its package."""

from __future__ import annotations

import ast
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("components", "fmus", "orchestrator")


def defined(source: Path) -> set[str]:
    """The public names that a module defines with a class statement or an assignment; functions are told by modules."""
    found: set[str] = set()
    for node in ast.parse(source.read_text("utf-8")).body:
        if isinstance(node, ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign):
            found |= {name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)}
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            found.add(node.target.id)
    return {name for name in found if not name.startswith("_")}


def test_a_public_class_or_constant_stands_in_one_module_only():
    places: dict[str, list[str]] = defaultdict(list)
    for package in PACKAGES:
        for source in sorted((ROOT / package).rglob("*.py")):
            for name in defined(source):
                places[name].append(source.relative_to(ROOT).as_posix())
    assert len(places) > 400
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_a_file_s_name_stands_once_in_its_package(package):
    places: dict[str, list[str]] = defaultdict(list)
    for source in sorted((ROOT / package).rglob("*.py")):
        if source.stem not in {"__init__", "main"}:
            places[source.stem].append(source.relative_to(ROOT).as_posix())
    assert {name: found for name, found in places.items() if len(found) > 1} == {}
