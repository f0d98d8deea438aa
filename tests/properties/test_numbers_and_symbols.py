"""The equations stand once: with numbers and lowered to flat functions they say the same."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components import BLOCKS
from components.interfaces.record import pack, unpack
from fmus.lowering import lower


def flat(column) -> np.ndarray:
    return np.asarray(column).ravel()


@pytest.mark.parametrize("kind", BLOCKS.values(), ids=BLOCKS)
def test_the_start_state_is_the_same(kind, instance):
    block = instance(kind)
    assert flat(lower(kind).start(pack(block))).tolist() == pack(block.start()).tolist()


# a step of the multi-body vehicle from states drawn at random is stiff and takes seconds: it has a test of its own
DRAWN = {name: kind for name, kind in BLOCKS.items() if name != "commonroad_mb"}


@pytest.mark.parametrize("kind", DRAWN.values(), ids=DRAWN)
@settings(max_examples=40)
@given(data=st.data())
def test_outputs_and_next_state_are_the_same(kind, columns, instance, data):
    block, found, dims = instance(kind), lower(kind), kind.dimensions()
    x = pack(block.start()) if found.sampled else data.draw(columns(kind.states()))
    u = data.draw(columns(kind.inputs()))
    state, inputs = unpack(kind.state_type, x, dims), unpack(kind.input_type, u, dims)
    h = data.draw(st.floats(1e-3, 0.01))
    y = flat(found.output(x, u, pack(block)))
    x_next = found.step(x, u, pack(block), h)
    if found.sampled:
        x_next, y_held = x_next
        assert flat(y_held).tolist() == y.tolist()
    assert pack(block.output(state, inputs)) == pytest.approx(y, rel=1e-10, abs=1e-10)
    assert pack(block.step(state, inputs, h)) == pytest.approx(flat(x_next), rel=1e-10, abs=1e-10)
