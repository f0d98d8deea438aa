"""A file is read once while it stays what it is."""

from __future__ import annotations

import shutil

import pytest

from components.interfaces.problem import RequestError
from fmus.reading import known_archives, opening
from fmus.reading.archive import InterfaceType
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from tests.fmus.foreign import description3, kept_folder, library, pack


@pytest.fixture
def reads(monkeypatch):
    """The files that were read."""
    paths = []

    def read(path, *others, plain=opening.read):
        paths.append(path)
        return plain(path, *others)

    monkeypatch.setattr(opening, "read", read)
    monkeypatch.setattr(known_archives, "_known", type(known_archives._known)())
    return paths


@pytest.fixture
def file(tmp_path, built_fmus):
    path = tmp_path / "m.fmu"
    shutil.copy(built_fmus / "fmi3" / "coast.fmu", path)
    return path


def test_the_same_bytes_are_read_once(file, reads, built_fmus):
    first = open_fmu(file)
    assert open_fmu(file, {"m": 1000.0}) is first
    assert reads == [file]
    shutil.copy(built_fmus / "fmi3" / "bicycle.fmu", file)
    assert open_fmu(file).interface.kind == "bicycle"
    file.unlink()
    with pytest.raises(RequestError, match="no such file"):
        open_fmu(file)


def test_each_way_to_read_them_is_another_one(file, reads):
    found = [
        open_fmu(file),
        open_fmu(file, lenient=True),
        open_fmu(file, where="theirs.ssp, m.fmu"),
        open_fmu(file, interface_type=InterfaceType.CO_SIMULATION),
    ]
    assert len(reads) == len({id(archive) for archive in found}) == 4
    assert found[2].where == "theirs.ssp, m.fmu"


def test_the_last_that_were_read_are_known(file, reads, monkeypatch):
    monkeypatch.setattr(known_archives, "_MOST", 1)
    for lenient in (False, True, True, False):
        open_fmu(file, lenient=lenient)
    assert len(reads) == 3


def test_large_descriptions_are_not_kept_in_memory(file, reads, monkeypatch):
    monkeypatch.setattr(known_archives, "_MOST_VARIABLES", 3)
    open_fmu(file)
    open_fmu(file)
    assert len(reads) == 2


def test_structural_parameters_decide_what_is_read(tmp_path, reads):
    variables = [
        '<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="2"/>',
        '<Float64 name="y" valueReference="2" causality="output"><Dimension valueReference="1"/></Float64>',
    ]
    binary = library(kept_folder() / "known", Version.FMI3, '#include "echo3.c"')
    path = pack(tmp_path / "m.fmu", Version.FMI3, description3(variables, ['<Output valueReference="2"/>']), binary)
    assert [open_fmu(path, {"n": n}).interface.outputs[0].shape for n in (2, 3)] == [(2,), (3,)]
