"""Where a vehicle has left the surroundings of its road, from where on nobody looks at it any more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from components.interfaces.maths import Array
from orchestrator.system.scene import BESIDE_ROAD, ROAD_AT_MOST, Scene


@dataclass(frozen=True)
class Departure:
    """The first row in which a vehicle is outside the surroundings of the road."""

    row: int
    """Its number, from 0 on."""
    time: float
    """[s]"""
    x: float
    """[m]"""
    y: float
    """[m]"""

    def __str__(self) -> str:
        place = f"x = {self.x:.3g} m, y = {self.y:.3g} m"
        return f"the vehicle left the surroundings of the road at t = {self.time:g} s, {place}"


def in_surroundings(x: Array, y: Array, scene: Scene) -> NDArray[np.bool_]:
    """Whether each place `(n,)` [m] lies on the road or beside it; a place that is not finite does not."""
    beside = (y >= scene.y_right - BESIDE_ROAD) & (y <= scene.y_left + BESIDE_ROAD)
    return beside & (x >= ROAD_AT_MOST[0]) & (x <= ROAD_AT_MOST[1])


def has_left(x: Array, y: Array, scene: Scene) -> NDArray[np.bool_]:
    """Whether a vehicle at each place `(n,)` [m] has left the surroundings; where it is not finite nobody knows."""
    return np.isfinite(x) & np.isfinite(y) & ~in_surroundings(x, y, scene)


def departure(time: Array, x: Array, y: Array, scene: Scene) -> Departure | None:
    """Where a vehicle has left the surroundings of the road; None where it never did.

    Args:
        time: The time [s] of each row, `(n,)`.
        x: Its place along the road [m], `(n,)`; rows in which it is not finite do not count.
        y: The same across the road.
        scene: The road.
    """
    outside = has_left(x, y, scene)
    if not outside.any():
        return None
    row = int(np.argmax(outside))
    return Departure(row, float(time[row]), float(x[row]), float(y[row]))
