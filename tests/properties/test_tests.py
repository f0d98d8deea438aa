"""Tests mirror the sources: each source file has its own test, or a test says in its docstring that it shows the file.

The test of `fmus/clock.py` is `tests/fmus/test_clock.py`, and so on. Otherwise the docstring of a test file names
the source in backquotes, by its name or by as much of its path as leaves no doubt: tests of a package name the files of
this package, all others those of all packages.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("components", "fmus", "orchestrator")
SOURCES = sorted(
    path.relative_to(ROOT).as_posix()
    for package in PACKAGES
    for path in (ROOT / package).rglob("*.py")
    if path.name != "__init__.py"
)
TESTS = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "tests").rglob("*.py"))
CITATION = re.compile(r"`([\w/]+\.py)`")


def mirror(source: str) -> str:
    """Where the test of a source file stands."""
    folder, _, name = source.rpartition("/")
    return f"tests/{folder}/test_{name}"


def cited(test: str, docstring: str) -> dict[str, list[str]]:
    """What a test's docstring names, with the files that each name may stand for, nearest first."""
    package = test.split("/")[1]
    near = [s for s in SOURCES if s.startswith(f"{package}/")] if package in PACKAGES else SOURCES

    def meant(name: str) -> list[str]:
        for files in (near, SOURCES, TESTS):
            if found := [file for file in files if f"/{file}".endswith(f"/{name}")]:
                return found
        return []

    return {name: meant(name) for name in CITATION.findall(docstring)}


def docstring_of(test: str) -> str:
    return ast.get_docstring(ast.parse((ROOT / test).read_text("utf-8"))) or ""


CITED = {test: names for test in TESTS if (names := cited(test, docstring_of(test)))}


def test_every_source_file_has_its_test_or_a_test_that_says_it_shows_it():
    shown = {file for names in CITED.values() for files in names.values() for file in files}
    assert len(SOURCES) > 200
    assert [s for s in SOURCES if mirror(s) not in TESTS and s not in shown] == []


@pytest.mark.parametrize("test", CITED)
def test_every_file_that_a_test_names_is_one_file(test):
    assert {name: files for name, files in CITED[test].items() if len(files) != 1} == {}


def test_a_test_that_shows_a_file_tests_something():
    named = {test for test, names in CITED.items() if any(f in SOURCES for found in names.values() for f in found)}
    showing = named | {mirror(source) for source in SOURCES} & {*TESTS}
    assert [test for test in sorted(showing) if "\ndef test_" not in (ROOT / test).read_text("utf-8")] == []


def test_names_are_understood_as_a_reader_understands_them():
    here = "tests/orchestrator/ssp/test_reader.py"
    assert cited(here, "Shows `archive.py`.") == {"archive.py": ["orchestrator/ssp/archive.py"]}
    assert cited(here, "Shows `reading/archive.py`.") == {"reading/archive.py": ["fmus/reading/archive.py"]}
    assert len(cited("tests/closed_loop/test_static.py", "Shows `archive.py`.")["archive.py"]) == 2
    assert cited(here, "As in `test_writer.py`.") == {"test_writer.py": ["tests/orchestrator/ssp/test_writer.py"]}
    assert cited(here, "Shows `chive.py`, and archive.py without quotes.") == {"chive.py": []}
