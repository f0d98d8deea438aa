"""The empty plug of the traffic holds nothing."""

from __future__ import annotations

from components.interfaces.record import pack
from components.interfaces.sockets import TrafficInputs


def test_all_slots_are_empty_at_any_time(make, vehicle):
    block = make("empty_road")
    u = TrafficInputs(ego=vehicle())
    state = block.step(block.start(), u, 0.1)
    assert pack(block.output(state, u)).tolist() == [0.0] * 64
