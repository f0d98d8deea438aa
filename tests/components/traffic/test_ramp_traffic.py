"""The paper's traffic: a slot of the bus for each obstacle, whatever the ego vehicle does."""

from __future__ import annotations

import numpy as np
import pytest

from components import RequestError
from components.interfaces.record import pack
from components.interfaces.sockets import TrafficInputs


@pytest.fixture(scope="module")
def nobody(vehicle):
    return TrafficInputs(ego=vehicle())


def test_slots_are_numbered_and_tell_whether_they_hold_an_obstacle(make, nobody):
    valid = [True, False, True, False, False, False, False, True]
    block = make("ramp_traffic", valid=valid, length=np.arange(1.0, 9.0), width=np.arange(2.0, 10.0))
    obstacles = block.output(block.start(), nobody).obstacles
    assert obstacles.id.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert obstacles.valid.astype(bool).tolist() == valid
    assert obstacles.length.tolist() == list(range(1, 9))
    assert obstacles.width.tolist() == list(range(2, 10))


def test_the_ego_vehicle_makes_no_difference(make, vehicle):
    block = make("ramp_traffic", valid=[True] * 8, x_start=np.arange(8.0), v_start=[10.0] * 8, v_final=[12.0] * 8)
    near, far = (TrafficInputs(ego=vehicle(x=x, v_x=v)) for x, v in ((0.0, 10.0), (1e3, 50.0)))
    assert pack(block.step(block.start(), near, 0.1)).tolist() == pack(block.step(block.start(), far, 0.1)).tolist()
    assert pack(block.output(block.start(), near)).tolist() == pack(block.output(block.start(), far)).tolist()


def test_a_list_that_is_too_long_names_the_block_that_takes_more(make):
    with pytest.raises(RequestError) as refused:
        make("ramp_traffic", x_start=np.zeros(20))
    assert str(refused.value) == (
        "ramp_traffic.x_start: found shape (20,); valid: shape (8,). The block `dense_traffic` holds 32 obstacles:"
        " `--traffic dense_traffic`, or `block` in the scenario."
    )
    with pytest.raises(RequestError) as refused:
        make("ramp_traffic", x_start=np.zeros(7))
    assert str(refused.value) == "ramp_traffic.x_start: found shape (7,); valid: shape (8,)"
