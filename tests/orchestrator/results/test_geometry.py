from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.results.geometry import box_corners, box_distance


def box(*values):
    return np.array([values], dtype=float)


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [
        ((0, 0, 0, 4, 2), (10, 0, 0, 4, 2), 6.0),
        ((0, 0, 0, 4, 2), (7, 6, 0, 4, 2), 5.0),  # corner to corner: 3, 4, 5
        ((0, 0, 0, 4, 2), (0, 0.5, 0, 1, 1), 0.0),  # inside
        ((0, 0, 0, 4, 2), (4, 0, 0, 4, 2), 0.0),  # touching
        ((0, 0, np.pi / 2, 4, 2), (0, 5, 0, 4, 2), 2.0),
        ((0, 0, np.pi / 4, 2, 2), (3, 0, 0, 2, 2), 2 - np.sqrt(2)),  # corner to side
    ],
)
def test_distances_that_can_be_drawn(a, b, distance):
    assert box_distance(box(*a), box(*b))[0] == pytest.approx(distance, abs=1e-12)


pose = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-4, 4), st.floats(0.5, 6), st.floats(0.5, 3))


@given(a=pose, b=pose, shift=st.floats(-5, 5))
def test_distance_is_symmetric_and_does_not_depend_on_the_frame(a, b, shift):
    there = box_distance(box(*a), box(*b))[0]
    assert box_distance(box(*b), box(*a))[0] == pytest.approx(there, abs=1e-9)
    moved = [box(p[0] + shift, p[1] - shift, *p[2:]) for p in (a, b)]
    assert box_distance(*moved)[0] == pytest.approx(there, abs=1e-9)


@given(a=pose)
def test_corners_are_half_a_diagonal_from_the_centre(a):
    corners = box_corners(box(*a))[0]
    np.testing.assert_allclose(np.hypot(*(corners - a[:2]).T), np.hypot(a[3], a[4]) / 2, rtol=1e-9)
