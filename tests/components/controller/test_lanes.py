"""Which lanes there are, and whether they are free."""

from __future__ import annotations

import pytest

from components.controller.lanes import third_lane


@pytest.mark.parametrize(
    ("y_third", "found"),
    [
        (-3.5, -3.5),  # on the other side of the own lane
        (7.0, 7.0),  # beyond the adjacent lane
        (-2.0, -2.0),  # a narrow one
        (1e6, 3.5),  # none
        (10.5, 3.5),  # next to neither
        (-7.0, 3.5),
        (0.0, 3.5),  # the own lane
        (3.5, 3.5),
        (1.75, 3.5),  # between the two
    ],
)
def test_a_third_lane_lies_next_to_one_of_the_two(y_third, found):
    assert third_lane(0.0, 3.5, y_third) == found
    assert third_lane(1.0, -2.5, 1.0 - y_third) == 1.0 - found  # the mirrored road, elsewhere
