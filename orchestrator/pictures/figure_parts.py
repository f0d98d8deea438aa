"""What the figures of a run and those of the reproduction share: sheets, the road, vehicles and obstacles, to scale."""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
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


def vehicle(axes: Axes, time: Array, pose: tuple[Array, ...], scene: Scene) -> None:
    """Draw the box of the vehicle once per second, or less often in a long run.

    Args:
        axes: The panel.
        time: The time [s] of each row, `(n,)`.
        pose: Position x, y and yaw angle in each row, each `(n,)`.
        scene: The size of the vehicle.
    """
    pause = _SNAPSHOTS * max(1.0, np.ceil((time[-1] - time[0]) / (_MOST_SNAPSHOTS * _SNAPSHOTS)))
    kept = np.unique(np.searchsorted(time, np.arange(time[0], time[-1] + 1e-9, pause) - 1e-9))
    x, y, psi = (values[kept] for values in pose)
    size = np.ones(len(kept))
    boxes = drawing.Boxes.of(x, y, psi, scene.ego_length * size, scene.ego_width * size)
    fill = to_rgba(EGO_COLOUR, 0.15)
    for i, corners in enumerate(drawing.outlines(boxes, 0.0)):
        label = f"ego, every {pause:g} s" if i == 0 else None
        axes.add_patch(Polygon(corners, facecolor=fill, edgecolor=EGO_COLOUR, linewidth=0.7, zorder=3, label=label))


def traffic(axes: Axes, columns: SignalColumns, buses: BusPaths, scene: Scene) -> None:
    """Draw the obstacles with their safety boundaries as they are at the end, and dotted as they were at the start.

    Args:
        axes: The panel.
        columns: The rows of the run.
        buses: The buses of its system.
        scene: The safety gap.
    """
    obstacles = drawing.obstacles(columns, buses)
    if obstacles is None or not len(obstacles[0].x):
        return
    boxes = obstacles[0]
    first, last = (boxes.where(np.arange(len(boxes.count)) == i) for i in (0, len(boxes.count) - 1))
    moved = first.x.shape != last.x.shape or not np.allclose([first.x, first.y], [last.x, last.y], atol=STILL)
    if moved:
        for i, corners in enumerate(drawing.outlines(first, 0.0)):
            start = {"linestyle": ":", "label": None if i else "obstacle, at the start"}
            axes.add_patch(Polygon(corners, fill=False, edgecolor=OBSTACLE_COLOUR, linewidth=0.8, zorder=2, **start))
    names: tuple[str | None, str | None] = ("obstacle, at the end" if moved else "obstacle", "safety boundary")
    bodies, boundaries = drawing.outlines(last, 0.0), drawing.outlines(last, scene.l_gap)
    for i, (box, around) in enumerate(zip(bodies, boundaries, strict=True)):
        axes.add_patch(Polygon(box, color=OBSTACLE_COLOUR, zorder=2, label=names[0]))
        axes.add_patch(Polygon(around, fill=False, edgecolor=OBSTACLE_COLOUR, linewidth=0.8, zorder=2, label=names[1]))
        middle = (last.x[i], last.y[i])
        axes.annotate(str(last.id[i]), middle, ha="center", va="center", fontsize=7, color="w", annotation_clip=True)
        names = (None, None)
