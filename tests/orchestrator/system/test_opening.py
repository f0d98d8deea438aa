"""The processes of the units of a system start together, and a description says who asked for such a process."""

from __future__ import annotations

import pytest

from fmus.units import unit_process
from orchestrator.system.opening import opening
from orchestrator.system.source import Fmu
from orchestrator.system.source_description import SourceDescription

pytestmark = pytest.mark.foreign  # processes are what these tests are about


@pytest.fixture
def stationary(built_fmus):
    return Fmu(built_fmus / "fmi3" / "stationary.fmu")


def test_as_many_processes_start_as_there_are_units_that_need_one(stationary):
    apart = stationary.in_own_process(30.0)
    with opening([apart, stationary, apart]):
        assert len(unit_process._ready) == 2
    assert not unit_process._ready
    for few in ([], [stationary], [apart]):
        with opening(few):
            assert not unit_process._ready


def test_a_description_says_whether_the_process_was_requested(stationary):
    assert not stationary.describe().requested
    apart = stationary.in_own_process(5.0).describe()
    assert isinstance(apart, SourceDescription)
    assert (apart.isolated, apart.requested) == (5.0, True)
    here = stationary.in_own_process(5.0).in_this_process().describe()
    assert (here.isolated, here.requested) == (None, True)
