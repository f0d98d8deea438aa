"""What people import: three packages whose names are loaded when they are used."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("components", "fmus", "orchestrator")
HEAVY = ("casadi", "fmpy", "numpy", "pandas", "rerun", "scipy", "matplotlib")


def test_importing_the_packages_imports_nothing_heavy():
    script = f"import sys, {', '.join(PACKAGES)}; print(*{{*{HEAVY}}} & {{*sys.modules}})"
    said = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True, cwd=ROOT)
    assert said.stdout.strip() == ""


@pytest.mark.parametrize("package", PACKAGES)
def test_every_name_can_be_used_and_is_seen_by_type_checkers(package):
    module = import_module(package)
    for name in module.__all__:
        assert getattr(module, name) is not None
    (typed,) = [n for n in ast.parse(Path(module.__file__).read_text("utf-8")).body if isinstance(n, ast.If)]
    imports = {alias.name: node.module for node in typed.body for alias in node.names}
    assert sorted(imports) == sorted(module.__all__)
    for name, where in imports.items():
        found = getattr(import_module(where), name)
        assert getattr(module, name) is found, "the name is taken from another module when the program runs"


@pytest.mark.parametrize("package", PACKAGES)
def test_a_name_is_not_hidden_by_a_module_of_the_package(package):
    """An import of `package.name` would replace the name by the module."""
    module = import_module(package)
    inside = {path.stem for path in Path(module.__file__).parent.iterdir()}
    assert not inside & set(module.__all__)


@pytest.mark.parametrize("package", PACKAGES)
def test_classes_and_functions_say_what_they_are(package):
    module = import_module(package)
    public = {name: getattr(module, name) for name in module.__all__}
    for name, thing in public.items():
        if inspect.isclass(thing) or inspect.isfunction(thing):
            assert inspect.getdoc(thing), name
    sections = {"Args:", "Returns:", "Raises:", "Yields:"}
    for name, function in public.items():
        if inspect.isfunction(function) and inspect.signature(function).parameters:
            assert sections & set(inspect.getdoc(function).split()), name
