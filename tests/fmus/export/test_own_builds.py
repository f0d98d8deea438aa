"""Our own builds are known by their bytes, wherever they lie; nothing else passes for one."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import fmus
from fmus.export.own_builds import STAMP_PATH, built_folder, is_own_build, note_build
from fmus.reading.opening import open_fmu
from tests.fmus.foreign import copied, entries


@pytest.fixture
def bicycle(built_fmus):
    return built_fmus / "fmi3" / "bicycle.fmu"


def is_own(path: Path) -> bool:
    return is_own_build(path, open_fmu(path).files)


def test_an_fmu_that_was_built_here_is_known_wherever_it_lies(bicycle, tmp_path):
    assert is_own(bicycle)
    assert is_own(Path(shutil.copy(bicycle, tmp_path / "another_name.fmu")))


def test_nothing_else_passes_for_one(bicycle, tmp_path):
    library = next(name for name in entries(bicycle) if name.startswith("binaries/"))
    # the stamp, the description and the name are those of ours, and only the code is another
    changed = copied(bicycle, tmp_path / "bicycle.fmu", {library: entries(bicycle)[library] + b"\0"})
    assert STAMP_PATH in open_fmu(changed).files
    assert not is_own(changed)
    stamped = is_own_build(copied(bicycle, tmp_path / "bare.fmu", {STAMP_PATH: None}), set())
    assert not stamped


def test_without_a_list_every_fmu_is_a_foreign_one(bicycle, tmp_path, monkeypatch):
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.setattr(fmus, "__file__", str(tmp_path / "fmus" / "__init__.py"))
    assert built_folder() == tmp_path / "fmus" / "built"
    assert not is_own(bicycle)
    note_build(bicycle)
    assert is_own(bicycle)
    shutil.rmtree(built_folder())
    (tmp_path / "fmus" / "built").touch()  # a place that cannot be written to
    note_build(bicycle)
    assert not is_own(bicycle)
