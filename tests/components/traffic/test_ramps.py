"""Obstacles that ramp, against the school formulas of uniform acceleration, in both blocks that have them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components import BLOCKS
from components.interfaces.record import pack
from components.interfaces.sockets import TrafficInputs

speed = st.floats(0, 40)


@pytest.fixture(scope="module", params=["ramp_traffic", "dense_traffic"])
def traffic(make, request):
    """Traffic with one obstacle of interest, which is in slot 1 at any time."""
    places = BLOCKS[request.param].N_o

    def one(v_start: float, v_final: float, a: float, **more: float):
        def slots(value: float) -> np.ndarray:
            return np.r_[value, np.zeros(places - 1)]

        values = {
            "valid": [True] + [False] * (places - 1),
            "v_start": slots(v_start),
            "v_final": slots(v_final),
            "a": slots(a),
        }
        return make(request.param, **values, **{name: slots(value) for name, value in more.items()})

    return one


@pytest.fixture(scope="module")
def nobody(vehicle):
    return TrafficInputs(ego=vehicle())


def travelled(v_start: float, v_final: float, a: float, t: float) -> tuple[float, float]:
    """Distance and speed after `t`, by cases."""
    if a == 0:
        return v_start * t, v_start
    end = abs(v_final - v_start) / a
    signed = math.copysign(a, v_final - v_start)
    if t <= end:
        return v_start * t + signed * t * t / 2, v_start + signed * t
    return (v_start + v_final) / 2 * end + v_final * (t - end), v_final


def seen(block, state, u) -> tuple[float, float]:
    obstacles = block.output(state, u).obstacles
    return float(obstacles.x[0]), float(obstacles.v[0])


@pytest.mark.parametrize(
    ("v_start", "v_final", "a"),
    [
        (10.0, 12.0, 1.0),  # up, reached on a step
        (10.0, 10.5, 1.0),  # up, reached on a step, soon
        (10.0, 11.53, 0.7),  # up, reached within a step
        (12.0, 5.0, 2.0),  # down
        (12.0, 0.0, 3.1),  # down to a stop within a step
        (0.0, 0.0, 1.0),  # standing
        (7.0, 7.0, 1.0),  # nothing to change
        (7.0, 9.0, 0.0),  # no acceleration: keeps its start speed
        (5.0, 5.01, 9.0),  # over within the first step
    ],
)
def test_each_kind_of_ramp_follows_the_school_formulas_at_every_tick(traffic, nobody, v_start, v_final, a):
    block = traffic(v_start, v_final, a, x_start=20.0)
    state = block.start()
    for tick in range(80):
        s, v = travelled(v_start, v_final, a, tick * 0.1)
        assert seen(block, state, nobody) == pytest.approx((20.0 + s, v), rel=1e-12, abs=1e-12)
        state = block.step(state, nobody, 0.1)


@given(
    v_start=speed,
    v_final=speed,
    a=st.one_of(st.just(0.0), st.floats(0.01, 10)),
    parts=st.lists(st.floats(1e-3, 2), min_size=1, max_size=8),
)
def test_the_motion_is_exact_however_time_is_divided(traffic, nobody, v_start, v_final, a, parts):
    block = traffic(v_start, v_final, a)
    at_once = block.step(block.start(), nobody, sum(parts))
    state = block.start()
    for h in parts:
        state = block.step(state, nobody, h)
    assert pack(state) == pytest.approx(pack(at_once), rel=1e-11, abs=1e-11)
    assert seen(block, at_once, nobody) == pytest.approx(
        travelled(v_start, v_final, a, sum(parts)), rel=1e-11, abs=1e-11
    )


@given(v_start=speed, v_final=speed, a=st.floats(0, 10), h=st.floats(1e-3, 100))
def test_the_speed_never_leaves_the_span_between_start_and_final(traffic, nobody, v_start, v_final, a, h):
    block = traffic(v_start, v_final, a)
    _, v = seen(block, block.step(block.start(), nobody, h), nobody)
    slack = 1e-14 * max(v_start, v_final)
    assert min(v_start, v_final) - slack <= v <= max(v_start, v_final) + slack


@given(psi=st.floats(-3.2, 3.2))
def test_an_obstacle_moves_along_its_heading(traffic, nobody, psi):
    block = traffic(10.0, 12.0, 1.0, x_start=5.0, y_start=-2.0, psi_start=psi)
    obstacles = block.output(block.step(block.start(), nobody, 3.0), nobody).obstacles
    moved = complex(obstacles.x[0] - 5.0, obstacles.y[0] + 2.0)
    assert moved == pytest.approx((2 * 11 + 12) * np.exp(1j * psi), rel=1e-12, abs=1e-12)
    assert obstacles.psi[0] == psi
    assert obstacles.v[0] == 12.0


def test_slots_move_independently(make, nobody):
    v_start, v_final, a = np.arange(8.0), np.array([9.0, 0, 5, 3, 0, 8, 6, 1]), np.array([0, 1, 2, 0.5, 3, 0, 1, 2.0])
    block = make("ramp_traffic", v_start=v_start, v_final=v_final, a=a, valid=[True] * 8)
    state = block.step(block.start(), nobody, 1.7)
    for i in range(8):
        assert (state.s[i], state.v[i]) == pytest.approx(travelled(v_start[i], v_final[i], a[i], 1.7), rel=1e-12)
