"""Figures of a run, as in a paper: where it drove, and the signals over time.

What a system does not have is left out, down to no figure at all. Object interface of matplotlib only: `pyplot` would
look for a screen and doubles the time to start.
"""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from orchestrator.pictures import drawing, plots
from orchestrator.pictures.plots import Plot
from orchestrator.pictures.signals import Cast, SignalColumns, cast, signals
from orchestrator.results.path_geometry import path_lines
from orchestrator.system.scene import Scene
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

_WIDTH: Final = 7.2
"""[inch] of all figures: a text column"""
_SNAPSHOTS: Final = 1.0
"""[s] between two drawn places of the vehicle"""
_STRETCH: Final = 65.0
"""[m] of road side by side, as long as there are not too many stretches"""
_MOST_STRETCHES: Final = 4
_BESIDE: Final = 10.0
"""[m] beside the road that are drawn at most"""
_STILL: Final = 0.1
"""[m] an obstacle that moves less stands still"""
_DPI: Final = 150
_EGO, _OBSTACLE, _PATH, _LIMIT = "#1f6fd1", "#d1602a", "#8a5cc9", "0.5"
_SERIES: Final = ("#1f6fd1", "#d1602a", "#2c9c69", "#8a5cc9")
_FILES: Final = (
    ("actuation", ("actuation.delta_f", "actuation.T_r")),
    ("yaw_rate", ("state.r",)),
    ("acceleration", ("motion.a_x", "motion.a_y")),
    ("friction", ("tyre.mu_f", "tyre.mu_r")),
    ("speed", ("state.v_x",)),
)


def draw(frame: pd.DataFrame | Mapping[str, Any], system: System, scene: Scene, folder: Path) -> list[Path]:
    """Draw what there is to draw into `folder`, and name the files."""
    columns, who = SignalColumns(frame, signals(system)), cast(system)
    made: dict[str, Figure | None] = {"trajectory": _trajectory(columns, who, scene)}
    drawn = [plot for found in plots.questions(system, columns.signals).values() for plot in found]
    for name, endings in _FILES:
        made[name] = _series(columns, [p for p in drawn if any(p.signals[0].endswith(f".{e}") for e in endings)])
    made["path_error"] = _path_error(columns, who)
    folder.mkdir(parents=True, exist_ok=True)
    files: list[Path] = []
    for name, figure in made.items():
        if figure is not None:
            files.append(folder / f"{name}.png")
            figure.savefig(files[-1], dpi=_DPI)
    return files


def _trajectory(columns: SignalColumns, who: Cast, scene: Scene) -> Figure | None:
    """The road from above, to scale: cut into stretches one below the other, so that a car stays larger than a dot."""
    state = columns.bus(who.plant, "state", "x", "y", "psi")
    if state is None or not np.isfinite(state).all(axis=0).any():
        return None
    x, y = (values[np.isfinite(state).all(axis=0)] for values in state[:2])
    low, high = float(x.min()) - 2 * scene.ego_length, float(x.max()) + 2 * scene.ego_length
    rows = int(np.clip(np.ceil((high - low) / _STRETCH), 1, _MOST_STRETCHES))
    bottom = max(min(scene.y_right, float(y.min())), scene.y_right - _BESIDE) - 1
    top = min(max(scene.y_left, float(y.max())), scene.y_left + _BESIDE) + 1
    span = (high - low) / rows
    height = rows * (_WIDTH * 0.9 * (top - bottom) / span + 0.35) + 0.75
    figure, panels = _sheet(height, rows, gap=0.3)
    for i, axes in enumerate(panels):
        stretch = (low + i * span, low + (i + 1) * span)
        _road(axes, scene, *stretch)
        _traffic(axes, columns, who, scene)
        _path(axes, columns, who, stretch)
        axes.plot(*state[:2], color=_EGO, linewidth=1.6, label="driven", zorder=4)
        _vehicle(axes, columns, state, scene)
        axes.set(xlim=stretch, ylim=(bottom, top), aspect="equal", ylabel="y [m]")
        axes.tick_params(labelsize=8)
    panels[-1].set_xlabel("x [m]")
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncols=6, fontsize=7, frameon=False)
    return figure


def _road(axes: Axes, scene: Scene, low: float, high: float) -> None:
    axes.axhspan(scene.y_right, scene.y_left, color="0.93", zorder=0)
    for edge in (scene.y_right, scene.y_left):
        axes.axhline(edge, color="0.2", linewidth=1.2, zorder=1)
    strokes = drawing.lane_marks(scene, low - 9, high + 9)
    axes.add_collection(LineCollection(list(strokes), colors="0.6", linewidths=1, zorder=1))


def _vehicle(axes: Axes, columns: SignalColumns, state: tuple[drawing.Array, ...], scene: Scene) -> None:
    """Where the vehicle was, once a second."""
    moments = np.arange(columns.time[0], columns.time[-1] + 1e-9, _SNAPSHOTS)
    kept = np.unique(np.searchsorted(columns.time, moments - 1e-9))
    x, y, psi = (values[kept] for values in state)
    size = np.ones(len(kept))
    boxes = drawing.Boxes.of(x, y, psi, scene.ego_length * size, scene.ego_width * size)
    fill = to_rgba(_EGO, 0.15)
    for i, corners in enumerate(drawing.outlines(boxes, 0.0)):
        label = f"ego, every {_SNAPSHOTS:g} s" if i == 0 else None
        axes.add_patch(Polygon(corners, facecolor=fill, edgecolor=_EGO, linewidth=0.7, zorder=3, label=label))


def _traffic(axes: Axes, columns: SignalColumns, who: Cast, scene: Scene) -> None:
    """The obstacles with their safety boundaries where they are at the end, and dotted where they were at the start."""
    found = drawing.obstacles(columns, who)
    if found is None or not len(found[0].x):
        return
    boxes = found[0]
    first, last = (boxes.where(np.arange(len(boxes.count)) == i) for i in (0, len(boxes.count) - 1))
    moved = first.x.shape != last.x.shape or not np.allclose([first.x, first.y], [last.x, last.y], atol=_STILL)
    if moved:
        for i, corners in enumerate(drawing.outlines(first, 0.0)):
            start = {"linestyle": ":", "label": None if i else "obstacle, at the start"}
            axes.add_patch(Polygon(corners, fill=False, edgecolor=_OBSTACLE, linewidth=0.8, zorder=2, **start))
    names: tuple[str | None, str | None] = ("obstacle, at the end" if moved else "obstacle", "safety boundary")
    bodies, boundaries = drawing.outlines(last, 0.0), drawing.outlines(last, scene.l_gap)
    for i, (box, around) in enumerate(zip(bodies, boundaries, strict=True)):
        axes.add_patch(Polygon(box, color=_OBSTACLE, zorder=2, label=names[0]))
        axes.add_patch(Polygon(around, fill=False, edgecolor=_OBSTACLE, linewidth=0.8, zorder=2, label=names[1]))
        middle = (last.x[i], last.y[i])
        axes.annotate(str(last.id[i]), middle, ha="center", va="center", fontsize=7, color="w", annotation_clip=True)
        names = (None, None)


def _path(axes: Axes, columns: SignalColumns, who: Cast, stretch: tuple[float, float]) -> None:
    """The path with its waypoints as the controller saw it when the vehicle entered this stretch of the road."""
    path = columns.bus(who.controller, "path", "x", "y")
    state = columns.bus(who.plant, "state", "x")
    if path is None or state is None:
        return
    row = int(np.argmax(state[0] >= stretch[0]))
    x, y = path[0][row], path[1][row]
    line = path_lines(x[None, :], y[None, :])[0]
    axes.plot(*line.T, color=_PATH, linewidth=1, linestyle="--", label="path", zorder=3)
    axes.plot(x, y, ".", color=_PATH, markersize=4, zorder=5)
    for label, p_x, p_y in zip(drawing.waypoint_labels(x, y), x, y, strict=True):
        if label and stretch[0] <= p_x <= stretch[1]:
            axes.annotate(label, (p_x, p_y), (0, -9), textcoords="offset points", ha="center", fontsize=6, color=_PATH)


def _series(columns: SignalColumns, plots: list[Plot]) -> Figure | None:
    """One panel per plot over a common time axis, with the limits that hold."""
    known = {s.path: s for s in columns.signals}
    plots = [p for p in plots if any(path in known for path in p.signals)]
    if not plots:
        return None
    figure, panels = _sheet(0.6 + 2.1 * len(plots), len(plots), gap=0.25, sharex=True)
    for axes, plot in zip(panels, plots, strict=True):
        shown = [known[path] for path in plot.signals if path in known]
        for i, signal in enumerate(shown):
            # what a controller asks for is held until its next sample
            steps = "steps-post" if ".actuation." in signal.path else "default"
            values = columns.of(signal.path)
            axes.plot(columns.time, values, color=_SERIES[i], linewidth=1.4, drawstyle=steps, label=signal.labels[0])
        for limit in plot.limits:
            axes.axhline(limit.value, color=_LIMIT, linestyle="--", linewidth=0.9)
            inside = -1 if limit.value > 0 else 1
            axes.annotate(
                limit.label,
                (0.008, limit.value),
                (0, 3 * inside),
                xycoords=axes.get_yaxis_transform(),
                textcoords="offset points",
                va="top" if inside < 0 else "bottom",
                fontsize=8,
                color=_LIMIT,
            )
        axes.set_ylabel(plot.title, fontsize=9)
        if len(shown) > 1:
            axes.legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, borderpad=0)
    return _finished(figure, panels)


def _path_error(columns: SignalColumns, who: Cast) -> Figure | None:
    error = drawing.errors(columns, who)
    if error is None:
        return None
    figure, panels = _sheet(2.7, 1)
    axes = panels[0]
    axes.plot(columns.time, error, color=_EGO, linewidth=1.4)
    axes.set_ylabel("Path error [m], left positive", fontsize=9)
    return _finished(figure, panels)


def _sheet(height: float, rows: int, *, gap: float = 0.0, sharex: bool = False) -> tuple[Figure, NDArray[Any]]:
    """A figure of `rows` panels with margins and gaps in inches: laying them out by trial takes as long as drawing."""
    figure = Figure(figsize=(_WIDTH, height))
    panels = figure.subplots(rows, 1, squeeze=False, sharex=sharex)[:, 0]
    left, right, bottom, top = 0.65, 0.15, 0.48, 0.32
    panel = (height - bottom - top - gap * (rows - 1)) / rows
    figure.subplots_adjust(
        left=left / _WIDTH,
        right=1 - right / _WIDTH,
        bottom=bottom / height,
        top=1 - top / height,
        hspace=gap / panel,
    )
    return figure, panels


def _finished(figure: Figure, panels: NDArray[Any]) -> Figure:
    for axes in panels:
        axes.grid(visible=True, color="0.88", linewidth=0.6)
        axes.margins(x=0)
        axes.tick_params(labelsize=8)
    panels[-1].set_xlabel("time [s]")
    return figure
