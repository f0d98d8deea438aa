"""FMUs are unpacked once; what is in the cache is what is in the archive, or is not used."""

from __future__ import annotations

import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest

from fmus.reading import kept_files as module
from fmus.reading.kept_files import KeptFiles, kept_files, sharing
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from fmus.units.make import fmu_unit
from tests.fmus.foreign import description2, library, pack, scalar


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """Where the cache of a test is."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(module, "_compared", {})
    return tmp_path / "cache" / "macrostep" / "unpacked"


@pytest.fixture
def archive(tmp_path, built_fmus):
    return open_fmu(Path(shutil.copy(built_fmus / "fmi3" / "coast.fmu", tmp_path)))


@pytest.fixture
def unpacked(monkeypatch):
    """The folders that something was unpacked into."""
    folders = []

    def unpack(path, folder, *others, plain=module.unpack):
        folders.append(folder)
        return plain(path, folder, *others)

    monkeypatch.setattr(module, "unpack", unpack)
    return folders


def another_process(monkeypatch):
    monkeypatch.setattr(module, "_compared", {})


def test_an_fmu_is_unpacked_once(archive, place, unpacked, monkeypatch):
    folder, remark = kept_files(archive)
    assert (folder.parent, remark) == (place, "")
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert files == archive.files
    assert kept_files(archive) == (folder, "")
    another_process(monkeypatch)
    assert kept_files(archive) == (folder, "")
    assert len(unpacked) == 1


def test_another_file_of_the_same_content_has_the_same_files_and_another_content_others(archive, tmp_path):
    folder, _ = kept_files(archive)
    copy = open_fmu(Path(shutil.copy(archive.path, tmp_path / "copy.fmu")))
    assert kept_files(copy).folder == folder
    with zipfile.ZipFile(copy.path, "a") as file:
        file.writestr("documentation/more.html", "")
    assert kept_files(open_fmu(copy.path)).folder != folder


def write(path):
    path.write_bytes(path.read_bytes()[::-1])


@pytest.mark.parametrize("anew", [False, True], ids=["same process", "another process"])
@pytest.mark.parametrize(
    "change",
    [
        lambda folder, library: write(library),
        lambda folder, library: write(folder / "modelDescription.xml"),
        lambda folder, library: library.unlink(),
        lambda folder, library: (library.rename(folder / "x"), library.symlink_to(folder / "x")),
        lambda folder, library: shutil.rmtree(folder / "sources"),
    ],
    ids=["library", "description", "library gone", "link", "folder gone"],
)
def test_files_that_have_changed_are_unpacked_again_and_told(archive, monkeypatch, change, anew):
    folder, _ = kept_files(archive)
    library = folder / archive.library
    content = library.read_bytes()
    change(folder, library)
    if anew:
        another_process(monkeypatch)
    assert kept_files(archive) == (folder, f"its files in the cache had changed, and were unpacked again ({folder})")
    assert library.read_bytes() == content
    assert not library.is_symlink()
    assert kept_files(archive) == (folder, "")


def test_a_file_that_somebody_has_added_is_removed(archive, monkeypatch):
    folder, _ = kept_files(archive)
    (folder / "binaries" / "more.so").touch()
    another_process(monkeypatch)
    assert kept_files(archive).remark.startswith("its files in the cache had changed")
    assert not (folder / "binaries" / "more.so").exists()


def test_without_a_cache_the_unit_runs_and_says_so(archive, place):
    place.parent.parent.mkdir()
    place.parent.write_text("")
    reason = f"{place}: File exists"
    expected = f"its files were unpacked for this run alone, as the cache cannot be used ({reason})"
    assert kept_files(archive) == (None, expected)
    unit = fmu_unit("plant", sharing(archive))
    assert unit.remarks == [expected]
    unit.enter_initialization({})
    unit.close()


def test_a_full_disk_is_told(archive, place, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda _: shutil._ntuple_diskusage(1, 1, 0))
    assert "MiB in an archive of" in kept_files(archive).remark
    assert kept_files(archive).folder is None


def test_an_fmu_that_was_replaced_since_it_was_read_is_not_mixed_up(archive, built_fmus):
    shutil.copy(built_fmus / "fmi3" / "bicycle.fmu", archive.path)
    assert kept_files(archive).folder is None
    archive.path.unlink()
    assert kept_files(archive) == KeptFiles(None)


def test_one_that_is_larger_than_the_cache_is_not_kept(archive, monkeypatch):
    monkeypatch.setattr(module, "LARGEST_CACHE", 1000)
    assert kept_files(archive) == KeptFiles(None)


def test_files_are_shared_where_no_fmu_can_tell_the_difference(archive, tmp_path):
    assert sharing(archive).shares_files
    assert not sharing(replace(archive, files=archive.files | {"resources/table.csv"})).shares_files
    assert not sharing(replace(archive, library=None)).shares_files
    once = '<CoSimulation modelIdentifier="m" canBeInstantiatedOnlyOncePerProcess="true"/>'
    text = description2([scalar("y", 1, "output")], ['<Unknown index="1" dependencies=""/>'], interface=once)
    path = pack(tmp_path / "m.fmu", Version.FMI2, text, library(tmp_path, Version.FMI2, '#include "echo2.c"'))
    assert not sharing(open_fmu(path)).shares_files
