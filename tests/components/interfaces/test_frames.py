"""Vectors and boxes in the road frame, left positive."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.frames import corners, slip_angle, to_road

finite = st.floats(-50, 50)


@given(psi=st.floats(-4, 4), forward=finite, left=finite)
def test_the_way_to_the_road_frame_is_a_rotation_of_the_complex_plane(psi, forward, left):
    turned = complex(forward, left) * np.exp(1j * psi)
    assert complex(*to_road(psi, forward, left)) == pytest.approx(turned, rel=1e-13, abs=1e-13)


def test_the_corners_of_a_box_start_front_left_and_run_counter_clockwise():
    assert corners(10.0, 1.0, 0.0, 4.0, 2.0) == [(12.0, 2.0), (8.0, 2.0), (8.0, 0.0), (12.0, 0.0)]
    turned = corners(0.0, 0.0, np.pi / 2, 4.0, 2.0)  # facing left: the front left corner is behind on the left
    assert np.allclose(turned, [(-1, 2), (-1, -2), (1, -2), (1, 2)], atol=1e-15)


@given(v_x=st.floats(1, 50), v_y=finite, delta=st.floats(-0.8, 0.8))
def test_a_moving_wheel_slips_as_the_paper_says(v_x, v_y, delta):
    assert slip_angle(v_x, v_y, delta, 1.0) == v_y / v_x - delta  # (3), to the last bit
    assert slip_angle(-v_x, v_y, delta, 1.0) == v_y / v_x + delta


@given(v_x=st.floats(-1, 1), v_y=finite, delta=st.floats(-0.8, 0.8), v_least=st.floats(1, 5))
def test_a_slow_wheel_does_not_slip_where_it_rolls_along_its_own_plane(v_x, v_y, delta, v_least):
    assert slip_angle(v_x, v_x * delta, delta, v_least) == pytest.approx(0, abs=1e-14)
    assert abs(slip_angle(v_x, v_y, delta, v_least)) <= (abs(v_y) + abs(delta)) / v_least * (1 + 1e-12)
    just_below, just_above = (slip_angle(v, v_y, delta, v_least) for v in np.nextafter(v_least, (0, 9)))
    assert just_below == pytest.approx(just_above, rel=1e-12, abs=1e-12)
