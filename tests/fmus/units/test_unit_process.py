"""Processes of units start at the same time, and end in any case; `test_isolated_unit` shows what they do between."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest

from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from fmus.units import unit_process as processes
from fmus.units.isolated_unit import IsolatedUnit
from fmus.units.unit import UnitError
from tests.fmus.foreign import description3, library, pack
from tests.waiting import ctrl_c_as_soon_as

pytestmark = pytest.mark.foreign  # processes are what these tests are about

Y = ['<Float64 name="y" valueReference="101" causality="output"/>']
OUTPUT = ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>']


@pytest.fixture
def stationary(built_fmus):
    return open_fmu(built_fmus / "fmi3" / "stationary.fmu")


def test_units_take_the_processes_that_were_started_for_them(stationary):
    with processes.started_processes(2):
        started = list(processes._ready)
        units = [IsolatedUnit(name, stationary) for name in "abc"]
        assert [unit._process for unit in units[:2]] == started
        assert units[2]._process not in started
    for unit in units:
        unit.close()
        assert not unit._process.is_alive


def test_processes_that_nobody_took_end():
    with suppress(KeyError), processes.started_processes(1):
        started = processes._ready[0]
        raise KeyError
    assert processes._ready == []
    assert not started.is_alive


STEPS = """
#include <stdio.h>
#include <unistd.h>
#define STATUS (fclose(fopen("{begun}", "w")), sleep({seconds}) * 0)
#include "echo3.c"
"""


def test_a_call_that_was_interrupted_is_waited_for_before_the_next(tmp_path):
    begun = tmp_path / "begun"
    source = STEPS.format(begun=begun, seconds=1)
    path = pack(tmp_path / "m.fmu", Version.FMI3, description3(Y, OUTPUT), library(tmp_path, Version.FMI3, source))
    unit = _ready_unit(path)
    ctrl_c_as_soon_as(begun.exists)
    with pytest.raises(KeyboardInterrupt):
        unit.step(0.0, 0.1)
    assert unit.step(0.1, 0.1) == 0
    unit.terminate()
    unit.close()


def test_a_call_that_was_interrupted_and_hangs_does_not_hold_up_the_end(tmp_path):
    begun = tmp_path / "begun"
    source = STEPS.format(begun=begun, seconds=100000)
    path = pack(tmp_path / "m.fmu", Version.FMI3, description3(Y, OUTPUT), library(tmp_path, Version.FMI3, source))
    unit = _ready_unit(path)
    ctrl_c_as_soon_as(begun.exists)
    with pytest.raises(KeyboardInterrupt):
        unit.step(0.0, 0.1)
    with pytest.raises(UnitError, match="no answer to `fmi3DoStep` within 2 s; its process has been ended"):
        unit.terminate()
    unit.close()  # the time limit of the test is far less than what the FMU sleeps


def _ready_unit(path: Path) -> IsolatedUnit:
    unit = IsolatedUnit("m", open_fmu(path))
    unit.bind({}, {})
    unit.enter_initialization({})
    unit.exit_initialization()
    return unit
