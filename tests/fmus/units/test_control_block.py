"""Requests and replies through memory: what one side writes is what the other side reads."""

from __future__ import annotations

import pytest

from fmus.toolchain.shared_counter import counters_work
from fmus.units.control_block import ControlBlock, QuickCall, QuickRequest

pytestmark = pytest.mark.skipif(not counters_work(), reason="it needs the futex of Linux on x86-64")


@pytest.fixture
def ends(tmp_path):
    """The block as the parent and as the child has it."""
    blocks = ControlBlock(tmp_path / "control"), ControlBlock(tmp_path / "control")
    yield blocks
    for block in blocks:
        block.close()


@pytest.mark.parametrize(
    "request_", [QuickRequest(QuickCall.MESSAGE), QuickRequest(QuickCall.STEP, set_first=True, t=0.3, h=1e-3)]
)
def test_a_request_is_read_as_it_was_made_and_answered_once(ends, request_):
    parent, child = ends
    for status in (0, 3, -1):
        parent.request(request_)
        assert not parent.is_answered(0.0)
        assert child.next_request() == request_
        child.answer(status)
        assert parent.is_answered(0.0)
        assert parent.reply == (status, False)
    parent.request(QuickRequest(QuickCall.UPDATE, get_after=True, t=-1.0))
    assert child.next_request() == (QuickCall.UPDATE, False, True, -1.0, 0.0)
    child.answer(message=True)
    assert parent.is_answered(0.0)
    assert parent.reply == (0, True)


def test_calls_have_the_names_of_their_methods():
    assert [call.method for call in QuickCall] == ["message", "get", "step", "activate", "update"]
