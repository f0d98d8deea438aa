"""What the pictures of a run consist of: boxes, the road, the path and the distance from it; plain numpy, no viewer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.interfaces.buses import VehicleState
from components.interfaces.maths import Array
from orchestrator.pictures.signals import OBSTACLE_SIGNALS, PATH_SIGNALS, POSE_SIGNALS, Recorded, SignalColumns
from orchestrator.results.geometry import box_distance
from orchestrator.results.path_geometry import path_error
from orchestrator.results.sightings import identities
from orchestrator.system.scene import Scene
from orchestrator.system.shown import BusPaths, signal_path

HEIGHT: Final = 1.4
"""[m] Height of all vehicles, which no signal carries."""

ROAD_BEFORE: Final = 40.0
"""[m] Length of the road that is drawn before the first and behind the last place of interest."""

NEAR: Final = 20.0
"""[m] Distance between centres up to which the gap between two boxes is measured."""

ERROR_SCALE: Final = 0.5
"""[m] Path error that is drawn in full red."""


@dataclass(frozen=True)
class Boxes:
    """The obstacles of n rows, one after the other; those of invalid slots are left out."""

    count: NDArray[np.int64]
    """Number of boxes in each row, `(n,)`."""
    row: NDArray[np.int64]
    """The row of each box, `(boxes,)`, as are the following."""
    x: Array
    y: Array
    psi: Array
    length: Array
    width: Array
    id: NDArray[np.int64]

    @classmethod
    def of(cls, x: Array, y: Array, psi: Array, length: Array, width: Array) -> Boxes:
        """One box per row, each field of shape `(n,)`."""
        row = np.arange(len(x), dtype=np.int64)
        return cls(np.ones_like(row), row, x, y, psi, length, width, row)

    def where(self, rows: NDArray[np.bool_]) -> Boxes:
        """Only the boxes of the rows that a mask `(n,)` selects."""
        kept = rows[self.row]
        return self._picked(kept, self.count[rows], (np.cumsum(rows) - 1)[self.row[kept]])

    def _picked(self, which: NDArray[Any], count: NDArray[np.int64], row: NDArray[np.int64]) -> Boxes:
        """The boxes that a mask or indices pick, in other rows."""
        x, y, psi, length, width = (values[which] for values in (self.x, self.y, self.psi, self.length, self.width))
        return Boxes(count, row, x, y, psi, length, width, self.id[which])

    def only(self, boxes: NDArray[np.bool_]) -> Boxes:
        """Only the boxes that a mask `(boxes,)` selects, in the same rows."""
        row, *rest = (getattr(self, name)[boxes] for name in ("row", "x", "y", "psi", "length", "width", "id"))
        return Boxes(np.bincount(row, minlength=len(self.count)), row, *rest)


class Nearest(NamedTuple):
    """The nearest obstacle in each of n rows."""

    gap: Array
    """[m] The distance between its box and that of the ego vehicle, `(n,)`; infinite where nobody is within `NEAR`."""
    id: NDArray[np.int64]


def obstacles(columns: SignalColumns, buses: BusPaths) -> tuple[Boxes, Array] | None:
    """The obstacles of a run.

    Args:
        columns: Its rows.
        buses: The buses of its system.

    Returns:
        The boxes, and all that is known of the obstacles row by row, `(n, values)`; None where they were not recorded.
    """
    signals = columns.bus(buses, *OBSTACLE_SIGNALS)
    if signals is None:
        return None
    valid = signals[0] != 0
    x, y, psi, length, width = (values[valid] for values in signals[2:])
    identity = identities(valid, signals[1])[valid]
    boxes = Boxes(valid.sum(axis=1), np.nonzero(valid)[0], x, y, psi, length, width, identity)
    return boxes, np.column_stack(signals)


def ego_boxes(columns: SignalColumns, buses: BusPaths, scene: Scene) -> Array | None:
    """The box of the ego vehicle in every row, `(n, 5)`: x and y of its centre, yaw angle, length, width."""
    pose = columns.bus(buses, *POSE_SIGNALS)
    if pose is None:
        return None
    return np.column_stack([*pose, np.tile([scene.ego_length, scene.ego_width], (len(columns.time), 1))])


def nearest(columns: SignalColumns, buses: BusPaths, scene: Scene, boxes: Boxes) -> Nearest | None:
    """The nearest obstacle in every row.

    Args:
        columns: The rows of a run.
        buses: The buses of its system.
        scene: The road, and the size of the ego vehicle.
        boxes: The obstacles in these rows.

    Returns:
        Its gap and identity; None where the place of the ego vehicle was not recorded.
    """
    if (ego := ego_boxes(columns, buses, scene)) is None:
        return None
    own = ego[boxes.row]
    other = np.column_stack([boxes.x, boxes.y, boxes.psi, boxes.length, boxes.width])
    close = np.hypot(boxes.x - own[:, 0], boxes.y - own[:, 1]) < NEAR
    gap, row = box_distance(own[close], other[close]), boxes.row[close]
    least, identity = np.full(len(ego), np.inf), np.zeros(len(ego), dtype=np.int64)
    falling = np.argsort(-gap, kind="stable")  # of several boxes in a row, the nearest is written last
    least[row[falling]], identity[row[falling]] = gap[falling], boxes.id[close][falling]
    return Nearest(least, identity)


def path_errors(columns: SignalColumns, buses: BusPaths) -> Array | None:
    """Lateral distance of the vehicle from the path as the controller saw it at the same instant.

    Args:
        columns: The rows of a run.
        buses: The buses of its system.

    Returns:
        The distances [m], `(n,)`, positive to the left; None where the place or the path was not recorded.
    """
    place = columns.bus(buses, VehicleState, "x", "y")
    path = columns.bus(buses, *PATH_SIGNALS)
    return path_error(*path, *place) if place and path else None


def has_path_errors(recorded: Recorded, buses: BusPaths) -> bool:
    """Whether all that `path_errors` needs is recorded at the same ticks."""
    record, *names = PATH_SIGNALS
    path = [signal_path(buses, record, name) for name in names]
    return recorded.together(*(signal_path(buses, VehicleState, axis) for axis in "xy"), *path)


def has_gaps(recorded: Recorded, buses: BusPaths) -> bool:
    """Whether all that `nearest` needs is recorded at the same ticks."""
    paths = [signal_path(buses, record, name) for record, *names in (POSE_SIGNALS, OBSTACLE_SIGNALS) for name in names]
    return recorded.together(*paths)


def quaternions(psi: Array) -> Array:
    """Rotations by the angles `psi` [rad] `(n,)` about the vertical axis, as quaternions x, y, z, w `(n, 4)`."""
    zero = np.zeros_like(psi)
    return np.column_stack([zero, zero, np.sin(psi / 2), np.cos(psi / 2)])


def outlines(boxes: Boxes, gap: float) -> Array:
    """The boxes, grown by `gap` [m] on every side, as closed polygons `(boxes, 5, 2)`."""
    return _around(boxes, gap, [1.0, -1.0, -1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0, 1.0])


def boundaries(boxes: Boxes, gap: float) -> Array:
    """The outlines with the heading, as polylines `(boxes, 7, 2)` from the middle to the front, then around the box."""
    return _around(boxes, gap, [0.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.0])


def _around(boxes: Boxes, gap: float, forward_shares: list[float], left_shares: list[float]) -> Array:
    """Points in the road frame, given in shares of half the length and half the width of each box."""
    forward = (boxes.length / 2 + gap)[:, None] * np.array(forward_shares)
    left = (boxes.width / 2 + gap)[:, None] * np.array(left_shares)
    c, s = np.cos(boxes.psi)[:, None], np.sin(boxes.psi)[:, None]
    return np.stack([boxes.x[:, None] + forward * c - left * s, boxes.y[:, None] + forward * s + left * c], axis=-1)


def lane_marks(scene: Scene, x_min: float, x_max: float) -> Array:
    """The broken lines between the lanes, as strokes `(strokes, 2, 2)` of 3 m with gaps of 6 m."""
    starts = np.arange(np.ceil(x_min / 9) * 9, x_max - 3, 9.0)
    lines = [(right + left) / 2 for right, left in pairwise(scene.lanes())]
    x, y = np.tile(starts, len(lines)), np.repeat(lines, len(starts))
    return np.stack([np.column_stack([x, y]), np.column_stack([x + 3, y])], axis=1)


def error_colours(error: Array) -> NDArray[np.uint8]:
    """Colours `(n, 3)` of path errors [m] `(n,)`: from green for none over yellow to red for `ERROR_SCALE` and more."""
    stops: Array = np.array([[70, 200, 120], [245, 205, 70], [235, 65, 60]], dtype=float)
    share = np.clip(np.abs(np.nan_to_num(error, nan=ERROR_SCALE)) / ERROR_SCALE, 0, 1)
    channels: list[Array] = [np.interp(share, [0, 0.5, 1], stops[:, i]) for i in range(3)]
    return np.column_stack(channels).astype(np.uint8)


def waypoint_labels(x: Array, y: Array) -> list[str]:
    """The labels P0..P14 of waypoints, row by row.

    Args:
        x: Waypoints along the road [m], `(waypoints,)` or `(n, waypoints)`.
        y: The same across the road.

    Returns:
        One label per waypoint; waypoints in the same place share the label of the first, and the others have none.
    """
    n = x.shape[-1]
    x, y = x.round(2), y.round(2)
    same = (x[..., :, None] == x[..., None, :]) & (y[..., :, None] == y[..., None, :])
    same |= np.eye(n, dtype=np.bool_)  # NaN does not equal itself
    return [label for first in same.argmax(axis=-1).reshape(-1, n).tolist() for label in _labels(tuple(first))]


@lru_cache(maxsize=256)
def _labels(firsts: tuple[int, ...]) -> tuple[str, ...]:
    """The labels of points, given the first point in the place of each."""
    labels: list[str] = []
    for i, first in enumerate(firsts):
        if first == i:
            labels.append(f"P{i}")
        else:
            labels[first] += f",{i}"
            labels.append("")
    return tuple(labels)


def raised(shapes: NDArray[Any], z: float) -> NDArray[Any]:
    """Points of the plane `(..., 2)` as points of the world `(..., 3)` at the height `z` [m]."""
    return np.concatenate([shapes, np.full((*shapes.shape[:-1], 1), z)], axis=-1)


def rgba(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Opaque colours `(n, 3)` as one number each, `(n,)`, with red in the highest byte."""
    r, g, b = colours.astype(np.uint32).T
    return (r << 24) | (g << 16) | (b << 8) | 0xFF
