"""What the process of an isolated unit does with the calls it is sent; across a real border in `test_isolated_unit`."""

from __future__ import annotations

import pytest

from components.interfaces.quantity import Type
from fmus.reading.opening import open_fmu
from fmus.units.control_block import QuickCall, QuickRequest
from fmus.units.isolated_messages import Instantiation, UnitCall, UnitReply
from fmus.units.isolated_process import _Host
from fmus.units.message_log import Message

pytestmark = pytest.mark.foreign  # processes are what these tests are about


@pytest.fixture
def host(built_fmus, tmp_path):
    archive = open_fmu(built_fmus / "fmi3" / "bicycle.fmu")
    made = _Host(Instantiation.of("m", archive, tmp_path / "columns", None))
    made.carry_out(UnitCall("bind"))
    made.carry_out(UnitCall("enter_initialization", ({},)))
    made.carry_out(UnitCall("exit_initialization", get_after=True))
    yield made
    made.carry_out(UnitCall("close"))


def test_inputs_are_set_before_and_outputs_shown_after_a_call_if_that_is_wanted(host):
    at_start = host._outputs[Type.FLOAT64].copy()
    host._inputs[Type.FLOAT64][:] = [0.1, 20.0]
    assert host.carry_out(UnitCall("step", (0.0, 0.1))).value in (0, None)
    assert (host._outputs[Type.FLOAT64] == at_start).all()
    host.carry_out(UnitCall("get", get_after=True))
    unset = host._outputs[Type.FLOAT64].copy()
    assert (unset != at_start).any()
    host.carry_out(UnitCall("step", (0.1, 0.1), set_first=True, get_after=True))
    host.carry_out(UnitCall("step", (0.2, 0.1), get_after=True))
    assert (host._outputs[Type.FLOAT64] != unset).any()


def test_a_quick_call_gives_a_status_or_a_whole_reply(host):
    at_start = host._outputs[Type.FLOAT64].copy()
    assert host.carry_out_quickly(QuickRequest(QuickCall.STEP, set_first=True, get_after=True, t=0.0, h=0.1)) == 0
    assert (host._outputs[Type.FLOAT64] != at_start).any()
    assert host.carry_out_quickly(QuickRequest(QuickCall.GET, get_after=True)) == 0
    host._unit.messages.append("all is well")
    assert host.carry_out_quickly(QuickRequest(QuickCall.GET)) == 0
    host._unit.remarks.append("a remark")
    assert host.carry_out_quickly(QuickRequest(QuickCall.GET)) == UnitReply(
        None, (Message("all is well"),), ("a remark",)
    )
    assert not host._unit.messages
    assert host.carry_out_quickly(QuickRequest(QuickCall.GET)) == 0, "each remark is told once"


def test_states_stay_here_and_are_known_by_numbers(host):
    first, second = (host.carry_out(UnitCall("save")).value for _ in range(2))
    assert (first, second) == (1, 2)
    host.carry_out(UnitCall("forget", (first,)))
    raised = host.carry_out(UnitCall("restore", (first,))).raised
    assert raised.action == "it failed in its process (KeyError: 1)"
    host.carry_out(UnitCall("restore", (second,)))
    assert host.carry_out(UnitCall("save")).value == 3
    assert "fired" not in host._methods, "a unit without Event Mode has no method for it"
