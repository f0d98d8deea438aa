"""What the figures of a run and those of the reproduction share: sheets, the road, vehicles and obstacles, to scale."""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from itertools import cycle
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from components.interfaces.maths import Array
from orchestrator.pictures import drawing
from orchestrator.pictures.signals import SignalColumns
from orchestrator.system.scene import Scene
from orchestrator.system.shown import BusPaths

WIDTH: Final = 7.2
"""[inch] Width of all figures, that of a text column."""
DPI: Final = 150
STRETCH: Final = 65.0
"""[m] Length of the road in one panel, unless that takes more than `MOST_STRETCHES` panels."""
MOST_STRETCHES: Final = 4
STILL: Final = 0.1
"""[m] An obstacle that moves by less than this stands still."""
EGO_COLOUR, OBSTACLE_COLOUR = "#1f6fd1", "#d1602a"
_SNAPSHOTS: Final = 1.0
"""[s] Time between two places of the vehicle that are drawn, as long as they are not too many."""
_MOST_SNAPSHOTS: Final = 200
_LABELLED: Final = 2 * STRETCH
"""[m] Length of the road up to which a time fits on a box."""
_HEIGHTS: Final = (-0.6, 0.6, 0.0)
"""[m] Where the times of the first, second and third obstacle stand across its box, which others may come to lie on."""
_ABOVE: Final = 0.4
"""[m] Distance of the times of the vehicle from its box, through whose middle the driven line runs."""
_HALO: Final = [withStroke(linewidth=1.2, foreground="w")]
"""The ground of a text that lines run through."""
_TEXT_COLOURS: Final = {EGO_COLOUR: "#124a91", OBSTACLE_COLOUR: "#7a3210"}
"""The colours of the times, darker than those of the boxes that they stand on."""


def sheet(height: float, rows: int, *, gap: float = 0.0, sharex: bool = False) -> tuple[Figure, NDArray[Any]]:
    """A figure with panels one below the other, laid out in inches: an automatic layout takes as long as the drawing.

    Args:
        height: Height of the figure [inch].
        rows: Number of panels.
        gap: Gap between panels [inch].
        sharex: Whether the panels have a common horizontal axis.

    Returns:
        The figure, and its panels `(rows,)`.
    """
    figure = Figure(figsize=(WIDTH, height))
    panels = figure.subplots(rows, 1, squeeze=False, sharex=sharex)[:, 0]
    left, right, bottom, top = 0.65, 0.15, 0.48, 0.32
    panel = (height - bottom - top - gap * (rows - 1)) / rows
    figure.subplots_adjust(
        left=left / WIDTH,
        right=1 - right / WIDTH,
        bottom=bottom / height,
        top=1 - top / height,
        hspace=gap / panel,
    )
    return figure, panels


def finished(figure: Figure, panels: NDArray[Any]) -> Figure:
    """A figure of signals over time with its grids and the label of the time axis.

    Args:
        figure: The figure.
        panels: Its panels, `(rows,)`.
    """
    for axes in panels:
        axes.grid(visible=True, color="0.88", linewidth=0.6)
        axes.margins(x=0)
        axes.tick_params(labelsize=8)
    panels[-1].set_xlabel("time [s]")
    return figure


def road(axes: Axes, scene: Scene, low: float, high: float) -> None:
    """Draw the road between two places.

    Args:
        axes: The panel.
        scene: The road.
        low: Where it begins [m].
        high: Where it ends [m].
    """
    axes.axhspan(scene.y_right, scene.y_left, color="0.93", zorder=0)
    for edge in (scene.y_right, scene.y_left):
        axes.axhline(edge, color="0.2", linewidth=1.2, zorder=1)
    strokes = drawing.lane_marks(scene, low - 9, high + 9)
    axes.add_collection(LineCollection(list(strokes), colors="0.6", linewidths=1, zorder=1))


def instants(time: Array) -> tuple[NDArray[np.int64], float]:
    """The rows in which vehicles are drawn: one per second, or fewer in a long run.

    Args:
        time: The time [s] of each row, `(n,)`.

    Returns:
        The rows, and the time [s] from one to the next.
    """
    pause = _SNAPSHOTS * max(1.0, float(np.ceil((time[-1] - time[0]) / (_MOST_SNAPSHOTS * _SNAPSHOTS))))
    return np.unique(np.searchsorted(time, np.arange(time[0], time[-1] + 1e-9, pause) - 1e-9)), pause


def vehicles(
    axes: Axes, columns: SignalColumns, buses: BusPaths, scene: Scene, seen: NDArray[np.bool_] | None = None
) -> None:
    """Draw the vehicle and the obstacles as they were at the same instants, with the time at each box.

    What is later is drawn stronger. The vehicle lies above the obstacles, so that none hides where it was before: an
    obstacle that moves comes to places where the vehicle has been, and the other way round.

    One that is not seen all the time is drawn as it was last and first seen.

    Args:
        axes: The panel, with its limits.
        columns: The rows of the run.
        buses: The buses of its system.
        scene: The size of the vehicle, and the safety gap.
        seen: The rows `(n,)` in which the vehicle is to be seen; all if not given.
    """
    rows = np.arange(len(columns.time)) if seen is None else np.flatnonzero(seen)
    kept, pause = instants(columns.time[rows])
    rows = rows[kept]
    times = _Times(axes, columns.time[rows])
    if (obstacles := drawing.obstacles(columns, buses)) is not None:
        boxes = obstacles[0].where(np.isin(np.arange(len(columns.time)), rows))
        for identity, height in zip(np.unique(boxes.id), cycle(_HEIGHTS), strict=False):
            _obstacle(axes, boxes.only(boxes.id == identity), scene, times, height)
    if (ego := drawing.ego_boxes(columns, buses, scene)) is not None:
        _vehicle(axes, drawing.Boxes.of(*ego[rows].T), times, f"ego, every {pause:g} s")


class _Times:
    """How the instants are told apart: by the strength of the colour and, where there is room, by the time.

    Args:
        axes: The panel, with its limits.
        time: The instants [s], `(n,)`.
    """

    def __init__(self, axes: Axes, time: Array) -> None:
        self._axes, self._time = axes, time

    def colour(self, colour: str, i: int, weakest: float, strongest: float) -> tuple[float, float, float, float]:
        """The colour of a box at the `i`-th instant, between two opacities."""
        share = i / max(len(self._time) - 1, 1)
        return to_rgba(colour, weakest + share * (strongest - weakest))

    def write(self, i: int, x: float, y: float, of: str, name: str = "") -> None:
        """Write the time of the `i`-th instant around a place, for boxes of a colour, if the place is in the panel."""
        low, high = self._axes.get_xlim()
        if low <= x <= high and high - low <= _LABELLED:
            style = {"ha": "center", "va": "center", "path_effects": _HALO, "color": _TEXT_COLOURS[of], "zorder": 6}
            self._axes.text(x, y, f"{name}{self._time[i]:g} s", fontsize=5.5, clip_on=True, **style)


def _vehicle(axes: Axes, boxes: drawing.Boxes, times: _Times, label: str) -> None:
    for i, corners in enumerate(drawing.outlines(boxes, 0.0)):
        fill, edge = times.colour(EGO_COLOUR, i, 0.08, 0.3), times.colour(EGO_COLOUR, i, 0.5, 1.0)
        axes.add_patch(Polygon(corners, facecolor=fill, edgecolor=edge, linewidth=0.7, zorder=3))
        times.write(i, boxes.x[i], corners[:, 1].max() + _ABOVE, EGO_COLOUR)
    axes.patches[-1].set_label(label)


def _obstacle(axes: Axes, boxes: drawing.Boxes, scene: Scene, times: _Times, height: float) -> None:
    """Draw one obstacle: at every instant if it moves, with the times at a height [m]; once if it stands still."""
    places = np.column_stack([boxes.x, boxes.y])
    if np.ptp(places, axis=0).max() <= STILL:
        _standing(axes, boxes, scene)
        return
    bodies, boundaries = drawing.outlines(boxes, 0.0), drawing.outlines(boxes, scene.l_gap)
    for i, body, (x, y) in zip(boxes.row, bodies, places, strict=True):
        fill, edge = times.colour(OBSTACLE_COLOUR, i, 0.08, 0.45), times.colour(OBSTACLE_COLOUR, i, 0.4, 1.0)
        axes.add_patch(Polygon(body, facecolor=fill, edgecolor=edge, linewidth=0.8, zorder=2))
        times.write(i, x, y + height, OBSTACLE_COLOUR, f"#{boxes.id[0]}, ")
    _name_once(axes, axes.patches[-1], "obstacle, at the same times")
    last = Polygon(boundaries[-1], fill=False, edgecolor=OBSTACLE_COLOUR, linewidth=0.8, zorder=2)
    _name_once(axes, axes.add_patch(last), "safety boundary")


def _standing(axes: Axes, boxes: drawing.Boxes, scene: Scene) -> None:
    body, around = drawing.outlines(boxes, 0.0)[0], drawing.outlines(boxes, scene.l_gap)[0]
    _name_once(axes, axes.add_patch(Polygon(body, color=OBSTACLE_COLOUR, zorder=2)), "obstacle")
    boundary = Polygon(around, fill=False, edgecolor=OBSTACLE_COLOUR, linewidth=0.8, zorder=2)
    _name_once(axes, axes.add_patch(boundary), "safety boundary")
    style = {"ha": "center", "va": "center", "fontsize": 7, "color": "w"}
    axes.annotate(str(boxes.id[0]), (boxes.x[0], boxes.y[0]), annotation_clip=True, **style)


def _name_once(axes: Axes, patch: Any, label: str) -> None:
    """Give a patch its name in the legend, unless another one of the panel has it."""
    if label not in axes.get_legend_handles_labels()[1]:
        patch.set_label(label)
