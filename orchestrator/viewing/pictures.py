"""What the pictures of a run are made of: columns by bus, boxes, the road, limits; plain numpy, no viewer.

Nothing here asks for more than there is: a unit that fills no socket, a bus that a controller does not offer, or a
column that was not recorded simply does not show.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from orchestrator.path_geometry import path_error
from orchestrator.scene import Scene
from orchestrator.system import System
from orchestrator.viewing.shapes import entity

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

Array: TypeAlias = NDArray[np.float64]

HEIGHT: Final = 1.4
"""[m] of all vehicles; no signal carries it"""

LARGEST: Final = 1e9
"""Geometry ends here: viewers compute with 32 bits"""

ROAD_BEFORE: Final = 40.0
"""[m] of road that is drawn before the first and behind the last place of interest"""

ROAD_AT_MOST: Final = (-1e4, 1e4)
"""[m] a vehicle that is lost gets no road"""

ERROR_SCALE: Final = 0.5
"""[m] path error that is drawn in full red"""

POSE: Final = ("state", "x", "y", "psi")
OBSTACLES: Final = ("obstacles", "valid", "id", "x", "y", "psi", "length", "width")
PATH: Final = ("path", "x", "y")
PLAN: Final = ("plan", "x", "y", "x_d", "y_upper", "y_lower")
"""Bus and signals that it takes to draw the vehicle, the obstacles, the path and the plan"""


@dataclass(frozen=True)
class Signal:
    """One recorded output of a system."""

    unit: str
    variable: Variable

    @cached_property
    def path(self) -> str:
        """The full name, `plant.state.v_x`."""
        return f"{self.unit}.{self.variable.name}"

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """The columns of the results that hold its elements."""
        return tuple(f"{self.unit}.{element}" for element in self.variable.elements)

    @cached_property
    def entity(self) -> str:
        """Where a recording holds it."""
        return entity("signals", *self.path.split("."))

    @property
    def bus(self) -> str:
        """Unit and bus, `plant.state`; the unit alone where the name has no bus."""
        return self.path.rpartition(".")[0]

    @cached_property
    def states(self) -> dict[int, str]:
        """The names of the values of an enumeration or a Boolean; empty for numbers and arrays."""
        quantity = self.variable.quantity
        if quantity.shape:
            return {}
        if quantity.type is Type.BOOLEAN:
            return {0: "false", 1: "true"}
        return {item.value: item.name for item in quantity.enumeration or ()}

    @property
    def is_number(self) -> bool:
        """Whether it can be drawn as a series; texts and binary values cannot."""
        return self.variable.quantity.type.is_number

    @property
    def is_text(self) -> bool:
        """Whether its values are texts."""
        return self.variable.quantity.type is Type.STRING

    @cached_property
    def names(self) -> list[str]:
        """The name of each element within its bus."""
        return [column.rpartition(".")[2] for column in self.columns]

    @cached_property
    def labels(self) -> list[str]:
        """Name and unit of each element as they stand in a legend."""
        unit = self.variable.quantity.unit
        return [name + (f" [{unit}]" if unit else "") for name in self.names]


def signals(system: System) -> list[Signal]:
    """All outputs of all units, in order."""
    return [Signal(unit, variable) for unit, source in system.units.items() for variable in source.interface.outputs]


def _paths(unit: str | None, bus: str, *names: str) -> list[str]:
    return [f"{unit}.{bus}.{name}" for name in names]


class Recorded:
    """Which signals of a system are recorded, and which of them at the same ticks: only those meet in a picture.

    Each of the `groups` names the columns that are recorded at the same ticks; all at every tick if not given.
    """

    def __init__(self, system: System, groups: Sequence[Collection[str]] | None = None) -> None:
        known = signals(system)
        kept = [{c for s in known for c in s.columns}] if groups is None else [set(group) for group in groups]
        found = [[s for s in known if group.issuperset(s.columns)] for group in kept]
        paths = {s.path for group in found for s in group}
        self.signals = [s for s in known if s.path in paths]
        self._numbers = [{s.path for s in group if s.is_number} for group in found]

    def bus(self, unit: str | None, bus: str, *names: str) -> bool:
        """Whether several signals of one bus are recorded at the same ticks."""
        return self.together(*_paths(unit, bus, *names))

    def together(self, *paths: str) -> bool:
        """Whether signals that are numbers are recorded at the same ticks."""
        return any(group.issuperset(paths) for group in self._numbers)


class Columns:
    """The rows of a run by signal, as numbers. A signal that was not recorded is not in `signals`; texts are apart."""

    def __init__(self, frame: pd.DataFrame | Mapping[str, Any], known: Sequence[Signal]) -> None:
        kept = {name: i for i, name in enumerate(map(str, frame))}
        recorded = [s for s in known if all(c in kept for c in s.columns)]
        self.signals = [s for s in recorded if s.is_number]
        """Recorded signals whose values are numbers"""
        self.texts: dict[str, list[list[str]]] = {
            s.path: [list(frame[c]) for c in s.columns] for s in recorded if s.is_text
        }
        """Values of each element of the recorded texts"""
        names = ["time", *(c for s in self.signals for c in s.columns)]
        at = {name: i for i, name in enumerate(names)}
        self._rows = _numbers(frame, names, list(kept))
        self._places = {s.path: [at[c] for c in s.columns] for s in self.signals}
        self.time: Array = self._rows[:, 0]

    def has(self, path: str) -> bool:
        """Whether a signal was recorded as numbers."""
        return path in self._places

    def of(self, path: str) -> Array:
        """The values (n,) of a scalar, or (n, elements) of an array."""
        places = self._places[path]
        if len(places) == 1:
            return self._rows[:, places[0]]
        return np.ascontiguousarray(self._rows[:, places])

    def bus(self, unit: str | None, bus: str, *names: str) -> tuple[Array, ...] | None:
        """Several signals of one bus, cut to what a picture can hold; `None` unless all of them are there."""
        paths = _paths(unit, bus, *names)
        if not all(path in self._places for path in paths):
            return None
        return tuple(np.clip(self.of(path), -LARGEST, LARGEST) for path in paths)


def _numbers(frame: Any, names: list[str], kept: list[str]) -> Array:
    """The columns `names` side by side, in Fortran order; column by column costs ten times as much in short frames."""
    blocks = getattr(frame, "dtypes", None)
    if blocks is not None and all(kind.kind in "fiub" for kind in blocks.unique()):
        rows = frame.to_numpy(dtype=np.float64)
        at = {name: i for i, name in enumerate(kept)}
        return np.asfortranarray(rows if names == kept else rows[:, [at[name] for name in names]])
    return np.asfortranarray(np.column_stack([np.asarray(frame[n], dtype=np.float64) for n in names]))


@dataclass(frozen=True)
class Cast:
    """Which unit plays which part in the picture: the first that fills the socket, or none."""

    plant: str | None
    traffic: str | None
    controller: str | None


def cast(system: System) -> Cast:
    """The cast of a system."""
    filled = {socket.name: unit for unit, socket in reversed(list(system.sockets.items()))}
    return Cast(filled.get("plant"), filled.get("traffic"), filled.get("controller"))


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


def obstacles(columns: Columns, who: Cast) -> tuple[Boxes, Array] | None:
    """The obstacles that the traffic shows, and all that is known of them row by row."""
    found = columns.bus(who.traffic, *OBSTACLES)
    if found is None:
        return None
    valid = found[0] != 0
    identity, x, y, psi, length, width = (values[valid] for values in found[1:])
    boxes = Boxes(valid.sum(axis=1), np.nonzero(valid)[0], x, y, psi, length, width, identity.astype(np.int64))
    return boxes, np.column_stack(found)


def errors(columns: Columns, who: Cast) -> Array | None:
    """Lateral distance [m] of the vehicle from the path as the controller saw it at the same instant."""
    ego = columns.bus(who.plant, "state", "x", "y")
    path = columns.bus(who.controller, *PATH)
    return path_error(*path, *ego) if ego and path else None


def has_errors(recorded: Recorded, who: Cast) -> bool:
    """Whether what `errors` takes is recorded at the same ticks."""
    return recorded.together(*_paths(who.plant, "state", "x", "y"), *_paths(who.controller, *PATH))


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
    """P0..P14; points on the same spot share one label, and the others stay empty."""
    labels: list[str] = []
    places: dict[tuple[float, float], int] = {}
    for i, place in enumerate(zip(x.round(2).tolist(), y.round(2).tolist(), strict=True)):
        first = places.setdefault(place, i)
        if first == i:
            labels.append(f"P{i}")
        else:
            labels[first] += f",{i}"
            labels.append("")
    return labels


def raised(shapes: NDArray[Any], z: float) -> NDArray[Any]:
    """Plane points (..., 2) at the height `z` [m]."""
    return np.concatenate([shapes, np.full((*shapes.shape[:-1], 1), z)], axis=-1)


def rgba(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Opaque colours (n, 3) as one number each, red in the highest byte."""
    r, g, b = colours.astype(np.uint32).T
    return (r << 24) | (g << 16) | (b << 8) | 0xFF
