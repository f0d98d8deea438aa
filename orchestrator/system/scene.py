"""The scene: the world around the units, which metrics and pictures need, and which no unit reads."""

from __future__ import annotations

from typing import Final

from components.interfaces.quantity import quantity
from components.interfaces.record import record

BESIDE_ROAD: Final = 10.0
"""[m] Width of the strips beside the road that are its surroundings."""
ROAD_AT_MOST: Final = (-1e4, 1e4)
"""[m] Ends of the longest road that is shown, also for a vehicle that has diverged."""


@record
class Scene:
    """The road, and the box of the ego vehicle around its centre of gravity."""

    ego_length: float = quantity("m", "length of the ego vehicle", min=0)
    ego_width: float = quantity("m", "width of the ego vehicle", min=0)
    y_left: float = quantity("m", "left edge of the road")
    y_right: float = quantity("m", "right edge of the road")
    y_lane: float = quantity("m", "centre of the ego's own lane")
    y_adjacent: float = quantity("m", "centre of the adjacent lane")
    y_third: float = quantity("m", "centre of a third lane; outside of the road where there is none")
    l_gap: float = quantity("m", "safety gap around an obstacle", min=0)

    def lanes(self) -> list[float]:
        """The centres of the lanes [m], from right to left; the own and the adjacent lane, and a third on the road."""
        third = [self.y_third] if self.y_right < self.y_third < self.y_left else []
        return sorted({self.y_lane, self.y_adjacent, *third})
