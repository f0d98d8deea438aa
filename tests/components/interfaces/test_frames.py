"""Vectors and boxes in the road frame, left positive."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.frames import corners, to_road

finite = st.floats(-50, 50)


@given(psi=st.floats(-4, 4), forward=finite, left=finite)
def test_the_way_to_the_road_frame_is_a_rotation_of_the_complex_plane(psi, forward, left):
    turned = complex(forward, left) * np.exp(1j * psi)
    assert complex(*to_road(psi, forward, left)) == pytest.approx(turned, rel=1e-13, abs=1e-13)


def test_the_corners_of_a_box_start_front_left_and_run_counter_clockwise():
    assert corners(10.0, 1.0, 0.0, 4.0, 2.0) == [(12.0, 2.0), (8.0, 2.0), (8.0, 0.0), (12.0, 0.0)]
    turned = corners(0.0, 0.0, np.pi / 2, 4.0, 2.0)  # facing left: the front left corner is behind on the left
    assert np.allclose(turned, [(-1, 2), (-1, -2), (1, -2), (1, 2)], atol=1e-15)
