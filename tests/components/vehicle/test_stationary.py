"""The empty plug of the plant stands where it is put."""

from __future__ import annotations

from components.interfaces.block import NoState
from components.interfaces.buses import Actuation
from components.interfaces.record import pack
from components.interfaces.sockets import PlantInputs


def test_it_stands_at_its_place_whatever_the_actuation(make):
    block = make("stationary", x_start=3.0, y_start=-1.0, psi_start=0.5)
    state = block.start()
    u = PlantInputs(actuation=Actuation(delta_f=0.4, T_r=200.0))
    for _ in range(3):
        state = block.step(state, u, 0.1)
        assert pack(block.output(state, u)).tolist() == [3.0, -1.0, 0.5, 0.0, 0.0, 0.0]
    assert isinstance(state, NoState)
