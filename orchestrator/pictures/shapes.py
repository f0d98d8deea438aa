"""What is drawn of a run, as plain data: shapes that change from row to row, and what stands from the start.

The vocabulary between what computes a picture (`run_picture`, `friction`, `events`, ...) and what sends it to a viewer
(`rerun_stream`, which alone knows the viewer's API). Places are points (n, 3) of the world or (n, 2) of a plane.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Colour: TypeAlias = tuple[int, int, int]
RowSelection: TypeAlias = NDArray[np.bool_] | NDArray[np.int64]
"""Which rows of a batch a shape belongs to: a mask, or row numbers that may repeat."""

_PLAIN = re.compile(r"[^\w.-]")


@lru_cache(maxsize=8192)
def entity(*parts: str) -> str:
    """The path of an entity; what is no letter, digit, `_`, `.` or `-` is escaped, an empty part is left out."""
    return "/" + "/".join(_PLAIN.sub(lambda found: "\\" + found[0], part) for part in parts if part)


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Something that is sent for the rows of a batch: for all of them, or for `rows`."""

    entity: str
    rows: RowSelection | None = None


@dataclass(frozen=True, kw_only=True)
class SeriesValues(Shape):
    """Numbers (n,), or (n, elements), as series over time."""

    values: NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class States(Shape):
    """The name of a state per row, shown from there on."""

    names: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class LogLines(Shape):
    """Lines of a log, each with its level (`INFO`, `WARN`, `ERROR`)."""

    texts: Sequence[str]
    levels: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class Pose(Shape):
    """Places (n, 3), and rotations (n, 4) as quaternions x, y, z, w, of everything below the entity."""

    places: Array
    rotations: Array | None = None


@dataclass(frozen=True, kw_only=True)
class Several(Shape):
    """Shapes of which each row has `counts` (n,), one after the other; one each if not given."""

    counts: Sequence[int] | NDArray[np.int64] | None = None
    labels: Sequence[str] | None = None
    colours: NDArray[np.uint32] | None = None


@dataclass(frozen=True, kw_only=True)
class Points(Several):
    """Points (points, 3), or (points, 2) in a plane."""

    places: NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class Lines(Several):
    """Polylines, each (points, 3) or (points, 2)."""

    strips: NDArray[Any] | Sequence[NDArray[Any]]


@dataclass(frozen=True, kw_only=True)
class Solids(Several):
    """Boxes by centre (boxes, 3), half of their sizes (boxes, 3) and rotation (boxes, 4)."""

    centres: Array
    halves: Array
    rotations: Array


@dataclass(frozen=True, kw_only=True)
class Style:
    """How the shapes at an entity look, or something that stands there from the start."""

    entity: str


@dataclass(frozen=True, kw_only=True)
class SeriesStyle(Style):
    """Legend, colour and width of each series."""

    names: Sequence[str]
    colours: Sequence[Colour]
    width: float = 1.5


@dataclass(frozen=True, kw_only=True)
class StateStyle(Style):
    """Colour of each state."""

    names: Sequence[str]
    colours: Sequence[Colour]


@dataclass(frozen=True, kw_only=True)
class PointStyle(Style):
    """Points of one colour; `size` in pixels, or in metres (`of_world`). No colour: the points have their own."""

    size: float
    colour: Colour | None = None
    of_world: bool = False
    plane: bool = False


@dataclass(frozen=True, kw_only=True)
class LineStyle(Style):
    """Lines of one colour, `size` in pixels."""

    size: float
    colour: Colour | None = None
    plane: bool = False


@dataclass(frozen=True, kw_only=True)
class SolidStyle(Style):
    """Boxes of one colour."""

    colour: Colour


@dataclass(frozen=True, kw_only=True)
class Still(Style):
    """Lines that stand from the start, `size` in pixels or (`of_world`) metres."""

    strips: NDArray[Any] | Sequence[NDArray[Any]]
    colour: Colour
    size: float
    of_world: bool = False
    labels: Sequence[str] | None = None


@dataclass(frozen=True, kw_only=True)
class Car(Style):
    """A vehicle's box at the origin, lying flat on the road (`height` small) or standing, with its heading."""

    length: float
    width: float
    height: float
    colour: Colour
    label: str
    label_at: tuple[float, float, float]
    """[m] in the vehicle's frame"""
    shared: bool = False
    """Whether others may stand in the same place, to be seen through it"""


@dataclass(frozen=True, kw_only=True)
class Surface(Style):
    """A rectangle of the ground by its corners."""

    x: tuple[float, float]
    y: tuple[float, float]
    colour: Colour


@dataclass(frozen=True, kw_only=True)
class Page(Style):
    """A text in Markdown."""

    text: str


class Memory:
    """What was sent last at each entity, so that only news is sent, from batch to batch."""

    def __init__(self) -> None:
        self._last: dict[str, NDArray[Any]] = {}

    def news(self, at: str, values: NDArray[Any]) -> NDArray[np.bool_]:
        """Which rows (n,) of `values` (n, m) differ from the row before them."""
        rows = np.ones(len(values), dtype=bool)
        rows[1:] = (values[1:] != values[:-1]).any(axis=1)
        before = self._last.get(at)
        if before is not None and before.shape == values[0].shape:
            rows[0] = bool((values[0] != before).any())
        self._last[at] = values[-1].copy()
        return rows

    def begins(self, at: str, holds: NDArray[np.bool_]) -> NDArray[np.int64]:
        """The rows where a condition (n,) begins to hold, as row numbers; in the very first row too."""
        before = np.concatenate([self._last.get(at, np.zeros(1, dtype=bool)), holds[:-1]])
        self._last[at] = holds[-1:].copy()
        return np.flatnonzero(holds & ~before)

    def before(self, at: str, values: NDArray[Any]) -> NDArray[Any]:
        """Each row's predecessor (n, m); the very first row is its own."""
        kept = self._last.get(at)
        self._last[at] = values[-1].copy()
        return np.concatenate([(values[:1] if kept is None else kept[None]), values[:-1]])
