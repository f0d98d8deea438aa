"""What the pictures of a run are made of: boxes, the road, the path and how far it is; plain numpy, no viewer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from orchestrator.pictures.shapes import Array
from orchestrator.pictures.signals import OBSTACLES, PATH, Cast, Recorded, SignalColumns, bus_paths
from orchestrator.results.path_geometry import path_error
from orchestrator.system.scene import Scene

HEIGHT: Final = 1.4
"""[m] of all vehicles; no signal carries it"""

ROAD_BEFORE: Final = 40.0
"""[m] of road that is drawn before the first and behind the last place of interest"""

ROAD_AT_MOST: Final = (-1e4, 1e4)
"""[m] a vehicle that is lost gets no road"""

ERROR_SCALE: Final = 0.5
"""[m] path error that is drawn in full red"""


@dataclass(frozen=True)
class Boxes:
    """The obstacles of n rows, those of invalid slots left out: `count` (n,) of them, one after the other."""

    count: NDArray[np.int64]
    row: NDArray[np.int64]
    x: Array
    y: Array
    psi: Array
    length: Array
    width: Array
    id: NDArray[np.int64]

    @classmethod
    def of(cls, x: Array, y: Array, psi: Array, length: Array, width: Array) -> Boxes:
        """One box per row."""
        row = np.arange(len(x), dtype=np.int64)
        return cls(np.ones_like(row), row, x, y, psi, length, width, row)

    def where(self, rows: NDArray[np.bool_]) -> Boxes:
        """Only the boxes of some rows."""
        kept = rows[self.row]
        row = (np.cumsum(rows) - 1)[self.row[kept]]
        rest = (getattr(self, name)[kept] for name in ("x", "y", "psi", "length", "width", "id"))
        return Boxes(self.count[rows], row, *rest)


def obstacles(columns: SignalColumns, who: Cast) -> tuple[Boxes, Array] | None:
    """The obstacles that the traffic shows, and all that is known of them row by row."""
    found = columns.bus(who.traffic, *OBSTACLES)
    if found is None:
        return None
    valid = found[0] != 0
    identity, x, y, psi, length, width = (values[valid] for values in found[1:])
    boxes = Boxes(valid.sum(axis=1), np.nonzero(valid)[0], x, y, psi, length, width, identity.astype(np.int64))
    return boxes, np.column_stack(found)


def errors(columns: SignalColumns, who: Cast) -> Array | None:
    """Lateral distance [m] of the vehicle from the path as the controller saw it at the same instant."""
    ego = columns.bus(who.plant, "state", "x", "y")
    path = columns.bus(who.controller, *PATH)
    return path_error(*path, *ego) if ego and path else None


def has_errors(recorded: Recorded, who: Cast) -> bool:
    """Whether what `errors` takes is recorded at the same ticks."""
    return recorded.together(*bus_paths(who.plant, "state", "x", "y"), *bus_paths(who.controller, *PATH))


def quaternions(psi: Array) -> Array:
    """Rotations (n, 4) about the vertical axis, as x, y, z, w."""
    zero = np.zeros_like(psi)
    return np.column_stack([zero, zero, np.sin(psi / 2), np.cos(psi / 2)])


def outlines(boxes: Boxes, gap: float) -> Array:
    """The boxes grown by `gap` on every side, as closed polygons (boxes, 5, 2)."""
    return _around(boxes, gap, [1.0, -1.0, -1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0, 1.0])


def boundaries(boxes: Boxes, gap: float) -> Array:
    """The outlines (boxes, 7, 2) with the heading: one line from the middle to the front, then around."""
    return _around(boxes, gap, [0.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.0])


def _around(boxes: Boxes, gap: float, ahead: list[float], beside: list[float]) -> Array:
    """Corners in shares of half the length and width, in the road frame."""
    forward = (boxes.length / 2 + gap)[:, None] * np.array(ahead)
    left = (boxes.width / 2 + gap)[:, None] * np.array(beside)
    c, s = np.cos(boxes.psi)[:, None], np.sin(boxes.psi)[:, None]
    return np.stack([boxes.x[:, None] + forward * c - left * s, boxes.y[:, None] + forward * s + left * c], axis=-1)


def lane_marks(scene: Scene, x_min: float, x_max: float) -> Array:
    """The broken line between the lanes, as strokes (strokes, 2, 2) of 3 m with gaps of 6 m."""
    y = (scene.y_lane + scene.y_adjacent) / 2
    x = np.arange(np.ceil(x_min / 9) * 9, x_max - 3, 9.0)
    return np.stack([np.column_stack([x, np.full_like(x, y)]), np.column_stack([x + 3, np.full_like(x, y)])], axis=1)


def error_colours(error: Array) -> NDArray[np.uint8]:
    """Green for no path error over yellow to red for `ERROR_SCALE` and more, (n, 3)."""
    stops: Array = np.array([[70, 200, 120], [245, 205, 70], [235, 65, 60]], dtype=float)
    share = np.clip(np.abs(np.nan_to_num(error, nan=ERROR_SCALE)) / ERROR_SCALE, 0, 1)
    channels: list[Array] = [np.interp(share, [0, 0.5, 1], stops[:, i]) for i in range(3)]
    return np.column_stack(channels).astype(np.uint8)


def waypoint_labels(x: Array, y: Array) -> list[str]:
    """P0..P14 for points (..., n), row by row; points on the same spot share one label, and the others stay empty."""
    n = x.shape[-1]
    x, y = x.round(2), y.round(2)
    same = (x[..., :, None] == x[..., None, :]) & (y[..., :, None] == y[..., None, :])
    same |= np.eye(n, dtype=np.bool_)  # also where there is no number
    return [label for first in same.argmax(axis=-1).reshape(-1, n).tolist() for label in _labels(tuple(first))]


@lru_cache(maxsize=256)
def _labels(firsts: tuple[int, ...]) -> tuple[str, ...]:
    """The labels of points, by the first point on the spot of each."""
    labels: list[str] = []
    for i, first in enumerate(firsts):
        if first == i:
            labels.append(f"P{i}")
        else:
            labels[first] += f",{i}"
            labels.append("")
    return tuple(labels)


def raised(shapes: NDArray[Any], z: float) -> NDArray[Any]:
    """Plane points (..., 2) at the height `z` [m]."""
    return np.concatenate([shapes, np.full((*shapes.shape[:-1], 1), z)], axis=-1)


def rgba(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Opaque colours (n, 3) as one number each, red in the highest byte."""
    r, g, b = colours.astype(np.uint32).T
    return (r << 24) | (g << 16) | (b << 8) | 0xFF
