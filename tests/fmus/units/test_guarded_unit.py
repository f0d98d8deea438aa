"""An FMU in this process that changes the process: all is as before after its calls, and the values are right."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fmus.toolchain.version import Version
from fmus.units.guarded_unit import GuardedUnit
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description3, library, pack

pytestmark = pytest.mark.foreign  # our own FMUs are not guarded

Y = ['<Float64 name="y" valueReference="101" causality="output"/>']
OUTPUT = ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>']


def made(folder, deed):
    """An FMU that does something in every step."""
    headers = "#define _GNU_SOURCE\n#include <fenv.h>\n#include <sys/stat.h>\n#include <unistd.h>"
    source = f'{headers}\n#define STATUS ({deed}, 0)\n#include "echo3.c"'
    path = library(folder / "made", Version.FMI3, source)
    return pack(folder / "m.fmu", Version.FMI3, description3(Y, OUTPUT), path)


def run(path):
    return simulate(System({"m": Fmu(path, in_process=True)}, {}), h=0.1, until=0.5)


@pytest.mark.parametrize("deed", ['chdir("/")', "umask(0777)", "fesetround(FE_UPWARD)", "feenableexcept(FE_DIVBYZERO)"])
def test_what_an_fmu_changes_in_its_steps_is_put_back(in_tmp_path, deed):
    mask = os.umask(0o22)
    os.umask(mask)
    rows = run(made(in_tmp_path, deed))
    assert Path.cwd() == in_tmp_path
    assert os.umask(mask) == mask
    assert 1.0 + 2.0**-54 == 1.0, "numbers are rounded to nearest"
    assert len(rows) == 6


def test_a_reset_is_guarded_and_forgets_what_was_said(in_tmp_path):
    unit = Fmu(made(in_tmp_path, "0"), in_process=True).open("m")
    unit.messages.append("a message")
    unit.warned()
    unit.enter_initialization({})
    os.chdir("/")  # as the FMU might
    unit.reset()
    assert Path.cwd() == in_tmp_path
    assert (len(unit.messages), unit.warnings) == (0, 0)
    unit.close()


def test_only_fmus_of_other_makers_are_guarded(in_tmp_path, built_fmus):
    theirs = Fmu(made(in_tmp_path, "0"), in_process=True).open("m")
    ours = Fmu(built_fmus / "fmi3" / "stationary.fmu").open("m")
    assert isinstance(theirs, GuardedUnit)
    assert not isinstance(ours, GuardedUnit)
    assert theirs.messages is theirs._inner.messages
    theirs.close()
    theirs.close()
    ours.close()


def test_a_library_that_is_refused_leaves_nothing_open(in_tmp_path):
    before = len(list(Path("/proc/self/fd").iterdir()))
    path = pack(in_tmp_path / "m.fmu", Version.FMI3, description3(Y, OUTPUT), Path(__file__))
    with pytest.raises(ValueError, match="found a text"):
        run(path)
    assert len(list(Path("/proc/self/fd").iterdir())) == before
