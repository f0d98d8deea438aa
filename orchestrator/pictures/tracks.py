"""Figures that compare several runs: the paths that they drove, their yaw rates, and their distance from the first.

Road, obstacles and vehicles are to scale, as in the figures of a single run.
"""
# pyright: basic
# matplotlib carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from components.interfaces.buses import VehicleState
from orchestrator.pictures import drawing
from orchestrator.pictures.figure_parts import (
    MOST_STRETCHES,
    STILL,
    STRETCH,
    WIDTH,
    finished,
    road,
    sheet,
    vehicles,
)
from orchestrator.pictures.signals import PATH_SIGNALS, SignalColumns
from orchestrator.results.path_geometry import path_lines
from orchestrator.system.scene import ROAD_AT_MOST, Scene
from orchestrator.system.shown import BusPaths, signal_path

_LINE_STYLES: Final[Mapping[str, tuple[str, Any, str]]] = {
    "MP tuned": ("#1f6fd1", "-", "o"),
    "MP literal": ("#8a5cc9", (0, (6, 2)), "*"),
    "LQR": ("#d1602a", (0, (2, 1.5)), "."),
    "two-level MP": ("#7a4a2a", "-.", "."),
    "Stanley": ("#b8a01c", "-.", "."),
    "pure pursuit": ("#c2417f", (0, (8, 2, 1, 2)), "."),
    "this FMU": ("#1f6fd1", "-", "o"),
    "the scenario's plant": ("0.25", (0, (4, 2)), "s"),
    "mpc-plus": ("#2c9c69", (0, (4, 1)), "^"),
}
"""Colour, dashes and marker of the labels that appear in several figures."""
_OTHERS: Final[Sequence[tuple[str, Any, str]]] = (
    ("#2c9c69", (0, (6, 2)), "s"),
    ("#8a5cc9", (0, (1, 1.5)), "D"),
    ("0.25", "-.", "v"),
)


@dataclass(frozen=True)
class Track:
    """The rows of a run, with what it takes to draw them."""

    label: str
    columns: SignalColumns
    buses: BusPaths
    scene: Scene

    @property
    def x(self) -> Any:
        """Position along the road [m], `(n,)`."""
        return self.columns.of(signal_path(self.buses, VehicleState, "x"))

    @property
    def y(self) -> Any:
        """Position across the road [m], `(n,)`."""
        return self.columns.of(signal_path(self.buses, VehicleState, "y"))

    @property
    def r(self) -> Any:
        """Yaw rate [rad/s], `(n,)`."""
        return self.columns.of(signal_path(self.buses, VehicleState, "r"))


def line_styles(labels: Sequence[str]) -> list[tuple[str, Any, str]]:
    """Colour, dashes and marker of each label; those that are not known take turns."""
    others = iter(_OTHERS * len(labels))
    return [_LINE_STYLES[label] if label in _LINE_STYLES else next(others) for label in labels]


def trajectories(tracks: Sequence[Track]) -> Figure | None:
    """The road from above, to scale, in stretches one below the other, with the paths that several controllers drove.

    The boxes are those of the first run and of the obstacles, once a second.
    """
    if not tracks:
        return None
    first = tracks[0]
    low, high = _extent(tracks)
    rows = int(np.clip(np.ceil((high - low) / STRETCH), 1, MOST_STRETCHES))
    bottom, top = first.scene.y_right - 1, first.scene.y_left + 1
    span = (high - low) / rows
    figure, panels = sheet(rows * (WIDTH * 0.9 * (top - bottom) / span + 0.35) + 1.0, rows, gap=0.3)
    for i, axes in enumerate(panels):
        stretch = (low + i * span, low + (i + 1) * span)
        axes.set(xlim=stretch, ylim=(bottom, top), aspect="equal", ylabel="y [m]")
        road(axes, first.scene, *stretch)
        vehicles(axes, first.columns, first.buses, first.scene)
        _desired(axes, first)
        for track, (colour, dashes, _) in zip(tracks, line_styles([t.label for t in tracks]), strict=True):
            axes.plot(track.x, track.y, color=colour, linestyle=dashes, linewidth=1.3, label=track.label, zorder=4)
        axes.tick_params(labelsize=8)
    panels[-1].set_xlabel("x [m]")
    _legend(figure, panels[-1])
    return figure


def _extent(tracks: Sequence[Track]) -> tuple[float, float]:
    """The least and the largest x [m] at which a vehicle is to be seen."""
    reach = tracks[0].scene.ego_length
    places = [values for track in tracks for values in (track.x.min(), track.x.max())]
    obstacles = drawing.obstacles(tracks[0].columns, tracks[0].buses)
    if obstacles is not None and len(obstacles[0].x):
        places += [obstacles[0].x.min(), obstacles[0].x.max()]
    low, high = np.clip([min(places), max(places)], *ROAD_AT_MOST)
    return float(low) - reach, float(high) + reach


def _desired(axes: Any, track: Track) -> None:
    """The path at the first instant at which its waypoints are not all in one lane."""
    path = track.columns.bus(track.buses, *PATH_SIGNALS)
    if path is None:
        return
    row = int(np.argmax(path[1].max(axis=1) - path[1].min(axis=1) > STILL))
    line = path_lines(path[0][row : row + 1], path[1][row : row + 1])[0]
    axes.plot(*line.T, color="0.35", linewidth=1, linestyle="--", label=f"desired path ({track.label})", zorder=3)


def yaw_rates(tracks: Sequence[Track]) -> Figure | None:
    """The yaw rates of several controllers over time."""
    if not tracks:
        return None
    figure, panels = sheet(2.9, 1)
    for track, (colour, dashes, _) in zip(tracks, line_styles([t.label for t in tracks]), strict=True):
        time = track.columns.time
        panels[0].plot(time, track.r, color=colour, linestyle=dashes, linewidth=1.3, label=track.label)
    panels[0].set_ylabel("yaw rate r [rad/s]", fontsize=9)
    _legend(figure, panels[0])
    return finished(figure, panels)


def distances(tracks: Sequence[Track]) -> Figure | None:
    """The distance of several trajectories from the first one at the same instant, on a logarithmic axis."""
    if len(tracks) < 2:  # noqa: PLR2004 - nothing to compare
        return None
    figure, panels = sheet(2.6, 1)
    first = tracks[0]
    for track, (colour, dashes, _) in list(zip(tracks, line_styles([t.label for t in tracks]), strict=True))[1:]:
        k = min(len(first.x), len(track.x))
        distance = np.hypot(track.x[:k] - first.x[:k], track.y[:k] - first.y[:k])
        shown, time = np.where(distance > 0, distance, np.nan), first.columns.time[:k]
        panels[0].semilogy(time, shown, color=colour, linestyle=dashes, linewidth=1.3, label=track.label)
    panels[0].set_ylabel("distance [m]", fontsize=9)
    _legend(figure, panels[0])
    return finished(figure, panels)


def _legend(figure: Figure, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncols=5, fontsize=7, frameon=False, borderaxespad=0.2)
