"""The functions that a run calls are enough: libraries that offer no others run, of every version and type."""

from __future__ import annotations

import pytest

from fmus.reading.needed_functions import needed_functions
from fmus.reading.opening import open_fmu
from fmus.toolchain.binaries import machine_code
from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import Version
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import copied, description1, description2, description3, library, pack, scalar, scalar1

EXACT = {"initial": "exact", "of_start": "0"}
MODELS = {
    Version.FMI1: description1(
        [scalar1("x", 1, causality="output", depends="", of_start="0")], implementation="", guid="me", counts=(1, 0)
    ),
    Version.FMI2: description2(
        [scalar("x", 1, "output", **EXACT), scalar("der(x)", 2, "local", of_derivative="1")],
        ['<Unknown index="1" dependencies=""/>'],
        interface='<ModelExchange modelIdentifier="m"/>',
        guid="me",
        derivatives=['<Unknown index="2" dependencies=""/>'],
    ),
    Version.FMI3: description3(
        [
            '<Float64 name="x" valueReference="1" causality="output" initial="exact" start="0"/>',
            '<Float64 name="der(x)" valueReference="2" derivative="1"/>',
        ],
        ['<Output valueReference="1" dependencies=""/>', '<ContinuousStateDerivative valueReference="2"/>'],
        interface='<ModelExchange modelIdentifier="m" needsCompletedIntegratorStep="true"/>',
        guid="me",
    ),
}
SLAVES = {
    Version.FMI1: ("slave1.c", description1([scalar1("x", 0, causality="output", depends="")])),
    Version.FMI2: ("echo2.c", description2([scalar("x", 101, "output")], ['<Unknown index="1" dependencies=""/>'])),
    Version.FMI3: (
        "echo3.c",
        description3(
            ['<Float64 name="x" valueReference="101" causality="output"/>'],
            ['<Output valueReference="101" dependencies=""/>'],
        ),
    ),
}


def narrowed(path, folder, source, *options):
    """The FMU with a library that offers only what is needed."""
    archive = open_fmu(path)
    before = "m_" if archive.version == Version.FMI1 else ""
    names = {f"{before}{n}" for n in needed_functions(archive)}
    (folder / "exports.map").write_text(f"{{ global: {'; '.join(sorted(names))}; local: *; }};")
    script = f"-Wl,--version-script={folder / 'exports.map'}"
    binary = library(folder / "narrow", archive.version, source, *options, script).read_bytes()
    assert machine_code(binary).exports == names
    return copied(path, folder / "narrow.fmu", {binary_path(archive.version, "m"): binary})


def rows(path):
    return simulate(System({"m": Fmu(path, lenient=True)}, {}), h=0.1, until=0.5)["m.x"].tolist()


@pytest.mark.parametrize("version", Version)
def test_a_model_runs_with_nothing_but_what_is_needed(tmp_path, version):
    source, model = f'#include "me{version}.c"', '-DMODEL="clockwork.h"'
    path = pack(tmp_path / "m.fmu", version, MODELS[version], library(tmp_path, version, source, model))
    expected = [0.0, 0.1, 0.2, 0.35, 0.55, 0.75]
    assert rows(path) == pytest.approx(expected)
    assert rows(narrowed(path, tmp_path, source, model)) == pytest.approx(expected)


@pytest.mark.parametrize("version", Version)
def test_a_slave_runs_with_nothing_but_what_is_needed(tmp_path, version):
    source, text = f'#include "{SLAVES[version][0]}"', SLAVES[version][1]
    path = pack(tmp_path / "m.fmu", version, text, library(tmp_path, version, source))
    assert rows(narrowed(path, tmp_path, source)) == rows(path) == [0.0] * 6
