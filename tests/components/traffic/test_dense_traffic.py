"""Traffic with more obstacles than slots: who is shown in which slot."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components import BLOCKS, RequestError
from components.interfaces.buses import SLOTS
from components.interfaces.record import pack
from components.interfaces.sockets import TrafficInputs
from fmus.lowering import lower

PLACES = BLOCKS["dense_traffic"].N_o
place = st.integers(-40, 40).map(float)  # whole numbers, so that some are equally far
shown = st.lists(st.booleans(), min_size=PLACES, max_size=PLACES)
places = st.lists(place, min_size=PLACES, max_size=PLACES)


def filled(values: list[float]) -> np.ndarray:
    """A list for all places, of which the first have the given values."""
    return np.r_[values, np.zeros(PLACES - len(values))]


@given(valid=shown, x=places, y=places, ego_x=place, ego_y=place)
def test_the_slots_hold_the_nearest_obstacles_in_the_order_of_their_distance(make, vehicle, valid, x, y, ego_x, ego_y):
    v = np.arange(PLACES) / 4
    block = make("dense_traffic", valid=valid, x_start=x, y_start=y, v_start=v, v_final=v, length=v + 1, width=v + 2)
    column = lower(type(block)).output(pack(block.start()), pack(vehicle(x=ego_x, y=ego_y)), pack(block))
    found = np.asarray(column).reshape(8, SLOTS)
    there = [i for i in range(PLACES) if valid[i]]
    nearest = sorted(there, key=lambda i: ((x[i] - ego_x) ** 2 + (y[i] - ego_y) ** 2, i))[:SLOTS]
    assert found[0].tolist() == [float(i < len(nearest)) for i in range(SLOTS)]
    assert found[1].astype(int).tolist()[: len(nearest)] == [i + 1 for i in nearest]
    for row, values in zip(found[2:], (x, y, np.zeros(PLACES), v, v + 1, v + 2), strict=True):
        assert row[: len(nearest)].tolist() == [values[i] for i in nearest]


def test_numbers_and_symbols_choose_the_same(make, vehicle):
    x = np.linspace(-100.0, 210.0, PLACES)
    block = make("dense_traffic", valid=[True] * PLACES, x_start=x, v_start=[5.0] * PLACES)
    u = TrafficInputs(ego=vehicle(x=31.0))
    found = block.output(block.start(), u)
    assert found.obstacles.id.tolist() == [14, 15, 13, 16, 12, 17, 11, 18]
    column = lower(type(block)).output(pack(block.start()), pack(u), pack(block))
    assert pack(found).tolist() == np.asarray(column).ravel().tolist()


def test_an_obstacle_keeps_its_id_while_the_ego_drives_past(make, vehicle):
    x = filled([10.0 * i for i in range(20)])
    block = make(
        "dense_traffic", valid=filled([True] * 20) > 0, x_start=x, y_start=filled([0.5 * i for i in range(20)])
    )
    slots = set()
    for ego_x in np.arange(0.0, 200.0, 7.0):
        seen = block.output(block.start(), TrafficInputs(ego=vehicle(x=ego_x))).obstacles
        assert seen.x.tolist() == [10.0 * (i - 1) for i in seen.id]
        assert seen.y.tolist() == [0.5 * (i - 1) for i in seen.id]
        slots |= {(slot, i) for slot, i in enumerate(seen.id.tolist()) if i == 10}
    assert len(slots) > 1  # it was in several of them


def test_an_ego_without_a_place_sees_the_first_in_the_list(make, vehicle):
    block = make("dense_traffic", valid=[True] * PLACES, x_start=np.arange(PLACES, 0.0, -1.0))
    for nowhere in (np.nan, np.inf, 1e100):
        seen = block.output(block.start(), TrafficInputs(ego=vehicle(x=nowhere))).obstacles
        assert seen.id.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]


def test_a_list_that_is_too_long_is_told(make):
    with pytest.raises(RequestError) as refused:
        make("dense_traffic", x_start=np.zeros(PLACES + 1))
    assert str(refused.value) == (
        "dense_traffic.x_start: found shape (33,); valid: shape (32,). No block holds more obstacles: leave out those"
        " that the ego never gets near to."
    )
