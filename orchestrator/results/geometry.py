"""Boxes on the road, many rows at once: their corners, and the distance between two of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from components.interfaces.maths import Array


def box_distance(a: Array, b: Array) -> Array:
    """Least distance [m] between the boxes of the same row.

    Args:
        a: One box per row, `(n, 5)`: x and y of its centre, yaw angle, length, width.
        b: The other box of each row, likewise.

    Returns:
        The distances, `(n,)`; 0 where the boxes touch or overlap.
    """
    distance: Any = shapely.distance(shapely.polygons(box_corners(a)), shapely.polygons(box_corners(b)))  # type: ignore[no-untyped-call]
    return distance


def box_corners(boxes: Array) -> Array:
    """The corners of boxes.

    Args:
        boxes: One box per row, `(n, 5)`: x and y of its centre, yaw angle, length, width.

    Returns:
        Its corners, `(n, 4, 2)`, counter-clockwise from the front left one.
    """
    x, y, psi, length, width = boxes.T
    forward = np.array([0.5, -0.5, -0.5, 0.5]) * length[:, None]
    left = np.array([0.5, 0.5, -0.5, -0.5]) * width[:, None]
    cos, sin = np.cos(psi)[:, None], np.sin(psi)[:, None]
    return np.stack([x[:, None] + forward * cos - left * sin, y[:, None] + forward * sin + left * cos], axis=-1)
