"""The ranges of the plots' axes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.pictures.shapes import SeriesStyle, SeriesValues
from orchestrator.recording.axes import Extremes, axis_range

NUMBERS = st.floats(-1e9, 1e9).filter(lambda x: x == 0 or abs(x) > 1e-6)


def written(low, high, room=5.0):
    """The numbers that the viewer writes at an axis: multiples of the smallest power of ten that leaves them room."""
    step = 10.0 ** math.ceil(math.log10((high - low) / room) - 1e-9)
    return math.floor(high / step) - math.ceil(low / step) + 1


@given(NUMBERS, NUMBERS)
def test_every_axis_has_two_numbers_and_shows_all(a, b):
    low, high = sorted((a, b))
    found = axis_range([(low, high)])
    if found is None:
        assert high - low <= 1e-9 * max(abs(low), abs(high)) or written(low, high) >= 2
    else:
        assert found[0] < low <= high < found[1]
        assert written(*found) >= 2
        assert found[1] - found[0] < 12 * (high - low), "not flattened without need"


@pytest.mark.parametrize(
    ("series", "expected"),
    [
        ([(-0.6, 0.63)], (-0.6, 1.0)),
        ([(1.5, 12.0)], (0.0, 12.0)),
        ([(-1.0, 2.0), (3.0, 3.4)], None),
        ([(5.0, 5.0)], None),
        ([], None),
    ],
)
def test_the_nearer_end_is_widened(series, expected):
    found = axis_range(series)
    if expected is None:
        assert found is None
    else:
        free = 0.04 * (expected[1] - expected[0])
        assert found == pytest.approx((expected[0] - free, expected[1] + free))


def test_the_extremes_of_what_passes_are_noted():
    extremes = Extremes()
    batches = (
        [SeriesValues(entity="/a", values=np.array([1, np.nan, 3])), SeriesStyle(entity="/a", names=[], colours=[])],
        [SeriesValues(entity="/a", values=np.array([[0.5, np.inf]])), SeriesValues(entity="/b", values=np.array([]))],
    )
    for batch in batches:
        assert list(extremes.noted(batch)) == batch
    assert extremes.ranges() == {"/a": (0.5, 3.0)}
