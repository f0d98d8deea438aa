"""Boxes on the road, many rows at once: their corners, and the distance between two of them."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

Rows: TypeAlias = NDArray[np.float64]
"""One value per row, shape (n,)"""


def box_distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> Rows:
    """Least distance [m] between the boxes of the same row; 0 where they touch or overlap.

    Each row of `a` and `b`, of shape (n, 5), is a box: x, y of the centre, yaw angle, length, width.
    """
    distance: Any = shapely.distance(shapely.polygons(box_corners(a)), shapely.polygons(box_corners(b)))  # type: ignore[no-untyped-call]
    return distance


def box_corners(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of boxes (x, y, psi, length, width), of shape (n, 4, 2): front left, then counter-clockwise."""
    x, y, psi, length, width = boxes.T
    forward = np.array([0.5, -0.5, -0.5, 0.5]) * length[:, None]
    left = np.array([0.5, 0.5, -0.5, -0.5]) * width[:, None]
    cos, sin = np.cos(psi)[:, None], np.sin(psi)[:, None]
    return np.stack([x[:, None] + forward * cos - left * sin, y[:, None] + forward * sin + left * cos], axis=-1)
