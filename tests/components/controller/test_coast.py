"""The empty plug of the controller lets the vehicle roll."""

from __future__ import annotations

from components.interfaces.record import pack
from components.interfaces.sockets import ControllerInputs


def test_it_asks_for_nothing_whatever_it_sees(make, vehicle, obstacles):
    block = make("coast")
    u = ControllerInputs(ego=vehicle(y=3.0, r=0.5), obstacles=obstacles({"x": 10.0, "y": 0.0}))
    state, outputs = block.sample(block.start(), u)
    assert pack(outputs).tolist() == [0.0, 0.0]
    assert pack(state).size == 0
