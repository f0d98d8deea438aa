"""Figures of a run, as in a paper: where it drove, and the signals over time.

What a system does not have is left out, down to no figure at all. Only the object interface of matplotlib is used,
because `pyplot` would look for a screen and take twice as long to import.
"""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from components.interfaces.buses import Actuation, Motion, Tyre, VehicleState
from components.interfaces.maths import Array
from orchestrator.pictures import drawing, plots
from orchestrator.pictures.figure_parts import (
    DPI,
    EGO_COLOUR,
    MOST_STRETCHES,
    OBSTACLE_COLOUR,
    STRETCH,
    WIDTH,
    finished,
    road,
    sheet,
    vehicles,
)
from orchestrator.pictures.plots import Limit, Plot
from orchestrator.pictures.signals import PATH_SIGNALS, POSE_SIGNALS, SignalColumns, signals
from orchestrator.results.departure import in_surroundings
from orchestrator.results.manifest import unfinished
from orchestrator.results.path_geometry import path_lines
from orchestrator.system.scene import Scene
from orchestrator.system.shown import BusPaths, shown, signal_path
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

_PATH_COLOUR, _LIMIT_COLOUR = "#8a5cc9", "0.5"
_SERIES: Final = (EGO_COLOUR, OBSTACLE_COLOUR, "#2c9c69", _PATH_COLOUR)
_SERIES_FILES: Final = (
    ("actuation", Actuation, ("delta_f", "T_r")),
    ("yaw_rate", VehicleState, ("r",)),
    ("acceleration", Motion, ("a_x", "a_y")),
    ("friction", Tyre, ("mu_f", "mu_r")),
    ("speed", VehicleState, ("v_x",)),
)
"""The name of a file, and the bus and its signals that it shows."""


def draw(frame: pd.DataFrame | Mapping[str, Any], system: System, scene: Scene, folder: Path) -> list[Path]:
    """Draw the figures of a run.

    Args:
        frame: The column `time` [s], and one column for each signal element that was kept at every tick.
        system: What was run.
        scene: The road, and the size of the ego vehicle.
        folder: Where the files are written to; made if it is not there and there are any.

    Returns:
        The files.
    """
    columns, buses = SignalColumns(frame, signals(system)), shown(system)
    figures: dict[str, Figure | None] = {"trajectory": _trajectory(columns, buses, scene)}
    answers = [plot for group in plots.questions(system, columns.signals).values() for plot in group]
    held = buses.get(Actuation)
    for name, record, names in _SERIES_FILES:
        paths = {signal_path(buses, record, signal) for signal in names}
        figures[name] = _series(columns, [plot for plot in answers if plot.signals[0].path in paths], held)
    figures["path_error"] = _path_error(columns, buses)
    drawn = {folder / f"{name}.png": figure for name, figure in figures.items() if figure is not None}
    if drawn:
        folder.mkdir(parents=True, exist_ok=True)
    for path, figure in drawn.items():
        with unfinished(path) as file:
            figure.savefig(file, dpi=DPI)
    return [*drawn]


def _trajectory(columns: SignalColumns, buses: BusPaths, scene: Scene) -> Figure | None:
    """The road from above, to scale, in stretches one below the other, so that a vehicle is not too small to see."""
    pose = columns.bus(buses, *POSE_SIGNALS)
    if pose is None or not (shown_rows := _shown_rows(pose, scene)).any():
        return None
    x, y = (values[shown_rows] for values in pose[:2])
    low, high = float(x.min()) - 2 * scene.ego_length, float(x.max()) + 2 * scene.ego_length
    rows = int(np.clip(np.ceil((high - low) / STRETCH), 1, MOST_STRETCHES))
    bottom, top = min(scene.y_right, float(y.min())) - 1, max(scene.y_left, float(y.max())) + 1
    span = (high - low) / rows
    height = rows * (WIDTH * 0.9 * (top - bottom) / span + 0.35) + 0.75
    figure, panels = sheet(height, rows, gap=0.3)
    for i, axes in enumerate(panels):
        stretch = (low + i * span, low + (i + 1) * span)
        axes.set(xlim=stretch, ylim=(bottom, top), aspect="equal", ylabel="y [m]")
        road(axes, scene, *stretch)
        vehicles(axes, columns, buses, scene, shown_rows)
        _path(axes, columns, buses, stretch)
        axes.plot(x, y, color=EGO_COLOUR, linewidth=1.6, label="driven", zorder=4)
        axes.tick_params(labelsize=8)
    panels[-1].set_xlabel("x [m]")
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncols=6, fontsize=7, frameon=False)
    return figure


def _shown_rows(pose: tuple[Array, ...], scene: Scene) -> NDArray[np.bool_]:
    """The rows `(n,)` up to the one in which the vehicle leaves the surroundings of the road."""
    finite = np.isfinite(pose).all(axis=0)
    inside = in_surroundings(pose[0], pose[1], scene)
    return finite & np.logical_and.accumulate(inside | ~finite)


def _path(axes: Axes, columns: SignalColumns, buses: BusPaths, stretch: tuple[float, float]) -> None:
    """The path with its waypoints as the controller saw it when the vehicle entered this stretch of the road."""
    path = columns.bus(buses, *PATH_SIGNALS)
    place = columns.bus(buses, VehicleState, "x")
    if path is None or place is None:
        return
    row = int(np.argmax(place[0] >= stretch[0]))
    x, y = path[0][row], path[1][row]
    line = path_lines(x[None, :], y[None, :])[0]
    axes.plot(*line.T, color=_PATH_COLOUR, linewidth=1, linestyle="--", label="path", zorder=3)
    axes.plot(x, y, ".", color=_PATH_COLOUR, markersize=4, zorder=5)
    for label, p_x, p_y in zip(drawing.waypoint_labels(x, y), x, y, strict=True):
        if label and stretch[0] <= p_x <= stretch[1]:
            axes.annotate(
                label, (p_x, p_y), (0, -9), textcoords="offset points", ha="center", fontsize=6, color=_PATH_COLOUR
            )


def _series(columns: SignalColumns, plots: Sequence[Plot], held: str | None) -> Figure | None:
    """One panel per plot over a common time axis, with the limits; `held` is the bus that is held between samples."""
    if not plots:
        return None
    figure, panels = sheet(0.6 + 2.1 * len(plots), len(plots), gap=0.25, sharex=True)
    for axes, plot in zip(panels, plots, strict=True):
        for i, signal in enumerate(plot.signals):
            steps = "steps-post" if signal.bus == held else "default"
            values = columns.of(signal.path)
            axes.plot(columns.time, values, color=_SERIES[i], linewidth=1.4, drawstyle=steps, label=signal.labels[0])
        for limit in plot.limits:
            _limit(axes, limit)
        axes.set_ylabel(plot.title, fontsize=9)
        if len(plot.signals) > 1:
            axes.legend(fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, borderpad=0)
    return finished(figure, panels)


def _limit(axes: Axes, limit: Limit) -> None:
    axes.axhline(limit.value, color=_LIMIT_COLOUR, linestyle="--", linewidth=0.9)
    inside = -1 if limit.value > 0 else 1
    axes.annotate(
        limit.label,
        (0.008, limit.value),
        (0, 3 * inside),
        xycoords=axes.get_yaxis_transform(),
        textcoords="offset points",
        va="top" if inside < 0 else "bottom",
        fontsize=8,
        color=_LIMIT_COLOUR,
    )


def _path_error(columns: SignalColumns, buses: BusPaths) -> Figure | None:
    error = drawing.path_errors(columns, buses)
    if error is None:
        return None
    figure, panels = sheet(2.7, 1)
    axes = panels[0]
    axes.plot(columns.time, error, color=EGO_COLOUR, linewidth=1.4)
    axes.set_ylabel("Path error [m], left positive", fontsize=9)
    return finished(figure, panels)
