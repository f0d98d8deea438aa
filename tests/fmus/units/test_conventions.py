"""Conventions turn values there and back, and mean what their formulas say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.frames import to_road
from fmus.units.conventions import BoxEnd, ReferencePoint, RoadFrameVelocity, SpeedAndSlip

NAMES = ("x", "y", "psi", "v_x", "v_y", "r", "length")
numbers = st.floats(-100, 100)


def bus(values):
    return {name: np.array(column, dtype=float) for name, column in zip(NAMES, values, strict=True)}


buses = st.integers(1, 8).flatmap(lambda n: st.lists(st.lists(numbers, min_size=n, max_size=n), min_size=7, max_size=7))
conventions = st.one_of(
    st.builds(ReferencePoint, st.floats(-5, 5)),
    st.builds(BoxEnd, st.sampled_from([-0.5, 0.5])),
    st.just(RoadFrameVelocity()),
)


@given(values=buses, convention=conventions)
def test_there_and_back_is_the_identity(values, convention):
    there = bus(values)
    convention.theirs(there)
    convention.ours(there)
    for name, wanted in bus(values).items():
        assert there[name] == pytest.approx(wanted, abs=1e-9)


@given(v=st.floats(0.1, 60), beta=st.floats(-1.5, 1.5))
def test_speed_and_slip_angle_there_and_back(v, beta):
    given_ = {"v_x": np.array([v]), "v_y": np.array([beta])}
    SpeedAndSlip().ours(given_)
    assert [given_["v_x"][0], given_["v_y"][0]] == pytest.approx([v * np.cos(beta), v * np.sin(beta)])
    SpeedAndSlip().theirs(given_)
    assert [given_["v_x"][0], given_["v_y"][0]] == pytest.approx([v, beta])


def test_the_rear_axle_lies_behind_the_centre_of_gravity():
    rear = bus([[10.0], [2.0], [0.3], [15.0], [0.2], [0.1], [0.0]])
    ReferencePoint(-1.4).ours(rear)
    assert rear["x"][0] == pytest.approx(10 + 1.4 * np.cos(0.3), abs=1e-15)
    assert rear["y"][0] == pytest.approx(2 + 1.4 * np.sin(0.3), abs=1e-15)
    assert rear["v_y"][0] == pytest.approx(0.2 + 1.4 * 0.1, abs=1e-15)
    assert (rear["psi"][0], rear["v_x"][0], rear["r"][0]) == (0.3, 15.0, 0.1)


def test_every_box_has_its_own_length():
    boxes = bus([[10.0, 20.0], [0.0, 3.0], [0.0, np.pi / 2], [0, 0], [0, 0], [0, 0], [4.0, 12.0]])
    BoxEnd(-0.5).ours(boxes)
    assert boxes["x"] == pytest.approx([12.0, 20.0])
    assert boxes["y"] == pytest.approx([0.0, 9.0])


def test_a_velocity_along_the_road_is_turned_into_the_body():
    state = bus([[0], [0], [0.4], *(np.array(to_road(0.4, 12.0, -0.5))[:, None]), [0], [0]])
    RoadFrameVelocity().ours(state)
    assert [state["v_x"][0], state["v_y"][0]] == pytest.approx([12.0, -0.5])
