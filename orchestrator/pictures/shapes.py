"""What is drawn of a run, as plain data: shapes that change from row to row, and styles that hold from the start.

This is the vocabulary between the modules that compute a picture (`run_picture`, `friction`, `events`, ...) and
`orchestrator.recording`, which alone knows the interface of the viewer. Places are points of the world `(n, 3)` or of a
plane `(n, 2)`, in metres.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.maths import Array

Colour: TypeAlias = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""
RowSelection: TypeAlias = NDArray[np.bool_] | NDArray[np.int64]
"""The rows of a batch that a shape belongs to: a mask `(n,)`, or row numbers that may repeat."""

_PLAIN = re.compile(r"[^\w.-]")


@lru_cache(maxsize=8192)
def entity(*parts: str) -> str:
    """The path of an entity.

    Args:
        parts: Its parts from the root on; an empty one is left out. All characters other than letters, digits, `_`, `.`
            and `-` are escaped, as the viewer does.
    """
    return "/" + "/".join(_PLAIN.sub(lambda found: "\\" + found[0], part) for part in parts if part)


@dataclass(frozen=True, kw_only=True)
class Shape:
    """Something that changes from row to row."""

    entity: str
    rows: RowSelection | None = None
    """The rows of the batch for which it is sent; all if not given."""


@dataclass(frozen=True, kw_only=True)
class SeriesValues(Shape):
    """Numbers `(n,)` or `(n, elements)` as series over time."""

    values: NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class States(Shape):
    """The name of a state for each row, which is shown from there on."""

    names: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class LogLines(Shape):
    """Lines of a log."""

    texts: Sequence[str]
    levels: Sequence[str]
    """`INFO`, `WARN` or `ERROR` for each line."""


@dataclass(frozen=True, kw_only=True)
class Texts(Shape):
    """A text in Markdown for each row."""

    texts: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class Pose(Shape):
    """Place and rotation of everything below the entity."""

    places: Array
    """The place in each row, `(n, 3)`."""
    rotations: Array | None = None
    """Quaternions x, y, z, w, `(n, 4)`."""


@dataclass(frozen=True, kw_only=True)
class Several(Shape):
    """Shapes of which a row may have several, one after the other."""

    counts: Sequence[int] | NDArray[np.int64] | None = None
    """How many each row has, `(n,)`; one if not given."""
    labels: Sequence[str] | None = None
    colours: NDArray[np.uint32] | None = None
    """One number per shape, red in the highest byte."""


@dataclass(frozen=True, kw_only=True)
class Points(Several):
    """Points of the world `(points, 3)` or of a plane `(points, 2)`."""

    places: NDArray[Any]


@dataclass(frozen=True, kw_only=True)
class Lines(Several):
    """Polylines, each with points of the world `(points, 3)` or of a plane `(points, 2)`."""

    strips: NDArray[Any] | Sequence[NDArray[Any]]


@dataclass(frozen=True, kw_only=True)
class Solids(Several):
    """Boxes."""

    centres: Array
    """The centres of the boxes, `(boxes, 3)`."""
    halves: Array
    """Half of length, width and height, `(boxes, 3)`."""
    rotations: Array
    """Quaternions x, y, z, w, `(boxes, 4)`."""


@dataclass(frozen=True, kw_only=True)
class Style:
    """How the shapes of an entity look, or something that stays the same during the whole run."""

    entity: str


@dataclass(frozen=True, kw_only=True)
class SeriesStyle(Style):
    """The name in the legend and the colour of each series, and the width of all."""

    names: Sequence[str]
    colours: Sequence[Colour]
    width: float = 1.5
    """[pixel] The width of the lines."""
    held: bool = False
    """Whether values hold until the next one, so that lines are steps."""


@dataclass(frozen=True, kw_only=True)
class StateStyle(Style):
    """The colour of each state."""

    names: Sequence[str]
    colours: Sequence[Colour]


@dataclass(frozen=True, kw_only=True)
class PointStyle(Style):
    """How points look."""

    size: float
    """The size [pixel], or [m] if `of_world`."""
    colour: Colour | None = None
    """None where the points have their own colours."""
    of_world: bool = False
    plane: bool = False
    """Whether they are points of a plane."""


@dataclass(frozen=True, kw_only=True)
class LineStyle(Style):
    """How lines look."""

    size: float
    """[pixel] The width of the lines."""
    colour: Colour | None = None
    """None where the lines have their own colours."""
    plane: bool = False
    """Whether they are lines of a plane."""


@dataclass(frozen=True, kw_only=True)
class SolidStyle(Style):
    """The colour of boxes."""

    colour: Colour


@dataclass(frozen=True, kw_only=True)
class Still(Style):
    """Polylines that stay the same during the whole run."""

    strips: NDArray[Any] | Sequence[NDArray[Any]]
    """Each with points of the world `(points, 3)` or of a plane `(points, 2)`."""
    colour: Colour
    size: float
    """Width [pixel], or [m] if `of_world`."""
    of_world: bool = False
    labels: Sequence[str] | None = None


@dataclass(frozen=True, kw_only=True)
class Car(Style):
    """The box of a vehicle at the origin of its frame, with an arrow in the direction of its heading."""

    length: float
    """[m] The length of the box."""
    width: float
    """[m] The width of the box."""
    height: float
    """[m] The height of the box; small for a footprint."""
    colour: Colour
    label: str
    label_at: tuple[float, float, float]
    """[m] The place of the label in the vehicle's frame."""
    shared: bool = False
    """Whether other vehicles may be in the same place, so that it must be transparent."""


@dataclass(frozen=True, kw_only=True)
class Surface(Style):
    """A rectangle of the ground."""

    x: tuple[float, float]
    """[m] The ends along the road."""
    y: tuple[float, float]
    """[m] The ends across the road."""
    colour: Colour


@dataclass(frozen=True, kw_only=True)
class Page(Style):
    """A text in Markdown; an empty one where `Texts` follow."""

    text: str


class Memory:
    """The last row of each named series of values, so that changes are seen across batches."""

    def __init__(self) -> None:
        self._last: dict[str, NDArray[Any]] = {}

    def news(self, at: str, values: NDArray[Any]) -> NDArray[np.bool_]:
        """Which rows differ from the row before them.

        Args:
            at: The name of the series.
            values: Its next rows, `(n, m)`.

        Returns:
            A mask `(n,)`; the very first row of a series counts as different.
        """
        rows = np.ones(len(values), dtype=bool)
        if not len(values):
            return rows
        rows[1:] = (values[1:] != values[:-1]).any(axis=1)
        before = self._last.get(at)
        if before is not None and before.shape == values[0].shape:
            rows[0] = bool((values[0] != before).any())
        self._last[at] = values[-1].copy()
        return rows

    def begins(self, at: str, holds: NDArray[np.bool_]) -> NDArray[np.int64]:
        """The rows where a condition begins to hold.

        Args:
            at: The name of the condition.
            holds: Whether it holds in its next rows, `(n,)`.

        Returns:
            Row numbers; the very first row is among them where the condition holds in it.
        """
        before = np.concatenate([self._last.get(at, np.zeros(1, dtype=bool)), holds[:-1]])
        self._last[at] = holds[-1:].copy()
        return np.flatnonzero(holds & ~before)

    def before(self, at: str, values: NDArray[Any]) -> NDArray[Any]:
        """The predecessor of each row.

        Args:
            at: The name of the series.
            values: Its next rows, `(n, m)`.

        Returns:
            The rows before them, `(n, m)`; the very first row of a series is its own predecessor.
        """
        kept = self._last.get(at)
        self._last[at] = values[-1].copy()
        return np.concatenate([(values[:1] if kept is None else kept[None]), values[:-1]])
