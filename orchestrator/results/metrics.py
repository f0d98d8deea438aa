"""Metrics of a run, computed from its rows alone, and the verdicts that follow from them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.arguments import checked_arguments
from components.interfaces.buses import (
    SLOTS,
    WAYPOINTS,
    Actuation,
    Motion,
    ObstacleList,
    Plan,
    Solver,
    SolverStatus,
    Tyre,
    VehicleState,
    Waypoints,
)
from components.interfaces.maths import Array
from orchestrator.results import path_geometry
from orchestrator.results.departure import Departure, departure
from orchestrator.results.finite_rows import FiniteColumns, Frame
from orchestrator.results.geometry import box_corners, box_distance
from orchestrator.system.scene import BESIDE_ROAD, Scene
from orchestrator.system.shown import BusPaths, signal_path

_BOX: Final = ("x", "y", "psi", "length", "width")
"""The signals of `obstacles` that give a box."""


@checked_arguments
def compute(frame: Frame, buses: BusPaths, scene: Scene) -> dict[str, float]:
    """All metrics that the columns of a run allow.

    Among them are `gap_obstacle`, the least distance between the box of the ego vehicle and that of any obstacle (0 on
    contact), and `gap_edge`, the least distance between the corners of the ego vehicle and the edges of the road
    (negative outside; `-BESIDE_ROAD` where it was further outside when nobody looked at it any more).

    Args:
        frame: Rows of consecutive ticks. Those in which the ego vehicle's state is not finite do not count, nor those
            from where it has left the road's surroundings; and none for a metric of another bus in which that is not.
        buses: The path of each output bus that the metrics are made from, as `shown` gives it for a system.
        scene: The road, and the size of the ego vehicle.

    Returns:
        The metrics by name, in SI units; those that are not finite are left out.
    """
    metrics: dict[str, float] = {}
    left = departure_of(frame, buses, scene)
    known = FiniteColumns(frame)
    for family, records in (
        (_motion, ()),
        (_acceleration, (Motion,)),
        (_tyres, (Tyre,)),
        (partial(_edge_gap, scene=scene), ()),
        (partial(_obstacle_gap, scene=scene), ()),
        (_actuation, (Actuation,)),
        (_path, (Waypoints,)),
        (_corridor, (Plan,)),
        (_solver, (Solver,)),
    ):
        rows = known.rows([buses[r] for r in (VehicleState, *records) if r in buses], left and left.row)
        if len(rows["time"]):
            metrics |= family(rows, buses)
    if left is not None and not scene.y_right - BESIDE_ROAD <= left.y <= scene.y_left + BESIDE_ROAD:
        metrics["gap_edge"] = min(metrics.get("gap_edge", 0.0), -BESIDE_ROAD)
    return {name: value for name, value in metrics.items() if np.isfinite(value)}


def departure_of(frame: Frame, buses: BusPaths, scene: Scene) -> Departure | None:
    """Where the vehicle left the surroundings of the road; None where it never did, or is not known.

    Args:
        frame: Rows of a run.
        buses: The path of each output bus of its system.
        scene: The road.
    """
    place = [signal_path(buses, VehicleState, axis) for axis in "xy"] if VehicleState in buses else []
    if not place or not _has(frame, *place):
        return None
    x, y = (_column(frame, path) for path in place)
    return departure(_column(frame, "time"), x, y, scene)


def verdicts(metrics: Mapping[str, float]) -> dict[str, bool]:
    """The verdicts on a run that its metrics allow, such as `no_contact` and `inside_road`."""
    verdict_of: dict[str, bool] = {}
    if "gap_obstacle" in metrics:
        verdict_of["no_contact"] = metrics["gap_obstacle"] > 0
    if "gap_edge" in metrics:
        verdict_of["inside_road"] = metrics["gap_edge"] >= 0
    if "mu_f_max" in metrics:
        verdict_of["within_friction_limit"] = max(metrics["mu_f_max"], metrics["mu_r_max"]) <= 1
    if {"solver_fallbacks", "solver_limits"} <= metrics.keys():
        verdict_of["solver_converged"] = metrics["solver_fallbacks"] == 0 and metrics["solver_limits"] == 0
    return verdict_of


def columns(frame: Frame, path: str, n: int) -> Array:
    """The columns of an array signal, `path[1]` to `path[n]`, as `(rows, n)`."""
    return np.stack([_column(frame, f"{path}[{i + 1}]") for i in range(n)], axis=1)


def edge_gap(boxes: Array, scene: Scene) -> Array:
    """Least distance [m] of the corners of each box to the edges of the road.

    Args:
        boxes: One box per row, `(n, 5)`: x and y of its centre, yaw angle, length, width.
        scene: The road.

    Returns:
        The distances, `(n,)`; negative where a corner is outside.
    """
    y = box_corners(boxes)[:, :, 1]
    return np.minimum(scene.y_left - y.max(axis=1), y.min(axis=1) - scene.y_right)


def _ego_boxes(frame: Frame, buses: BusPaths, scene: Scene) -> Array:
    """The box of the ego vehicle in every row, `(n, 5)`."""
    pose = np.stack([_column(frame, signal_path(buses, VehicleState, s)) for s in ("x", "y", "psi")], axis=1)
    size = np.tile([scene.ego_length, scene.ego_width], (len(pose), 1))
    return np.hstack([pose, size])


def _edge_gap(frame: Frame, buses: BusPaths, scene: Scene) -> dict[str, float]:
    if not _has(frame, *(signal_path(buses, VehicleState, s) for s in ("x", "y", "psi"))):
        return {}
    return {"gap_edge": float(edge_gap(_ego_boxes(frame, buses, scene), scene).min())}


def _obstacle_gap(frame: Frame, buses: BusPaths, scene: Scene) -> dict[str, float]:
    pose = [signal_path(buses, VehicleState, s) for s in ("x", "y", "psi")]
    if not _has(frame, *pose, *(signal_path(buses, ObstacleList, f"{s}[{SLOTS}]") for s in ("valid", *_BOX))):
        return {}
    valid = columns(frame, signal_path(buses, ObstacleList, "valid"), SLOTS) > 0
    parts = [columns(frame, signal_path(buses, ObstacleList, s), SLOTS) for s in _BOX]
    # what is not there may have any place, or none
    known = (~valid | np.isfinite(np.stack(parts)).all(axis=0)).all(axis=1)
    gap = _obstacle_gap_of(_ego_boxes(frame, buses, scene)[known], valid[known], np.stack(parts, axis=2)[known])
    return {"gap_obstacle": gap} if known.any() else {}


def _obstacle_gap_of(ego: Array, valid: NDArray[np.bool_], boxes: Array) -> float:
    """Least distance [m] of the boxes `ego` `(n, 5)` to the obstacles `(n, slots, 5)` of their rows; else infinity."""
    rows, slots = np.nonzero(valid)
    mine, theirs = ego[rows], boxes[rows, slots]
    apart = np.hypot(*(mine[:, :2] - theirs[:, :2]).T)
    around = 0.5 * (np.hypot(*mine[:, 3:].T) + np.hypot(*theirs[:, 3:].T))
    # Two boxes are no nearer than the circles around them, and no further apart than their centres.
    near = apart - around <= apart.min(initial=np.inf)
    return float(box_distance(mine[near], theirs[near]).min(initial=np.inf))


def _path_error(frame: Frame, buses: BusPaths) -> Array | None:
    """Distance [m] of the centre of gravity to the path of the same row, positive to the left of it.

    None where the controller shows no path, or one of both was not recorded.
    """
    place = [signal_path(buses, VehicleState, axis) for axis in "xy"]
    path = [signal_path(buses, Waypoints, axis) for axis in "xy"]
    if not _has(frame, *place, *(f"{axis}[{WAYPOINTS}]" for axis in path)):
        return None
    x, y = (_column(frame, axis) for axis in place)
    path_x, path_y = (columns(frame, axis, WAYPOINTS) for axis in path)
    return path_geometry.path_error(path_x, path_y, x, y)


def _motion(frame: Frame, buses: BusPaths) -> dict[str, float]:
    metrics: dict[str, Any] = {}
    yaw_rate, speed = (signal_path(buses, VehicleState, name) for name in ("r", "v_x"))
    if _has(frame, yaw_rate):
        r = _column(frame, yaw_rate)
        metrics |= {"r_peak": np.abs(r).max(), "r_rms": _rms(r), "r_total_variation": np.abs(np.diff(r)).sum()}
    if _has(frame, speed):
        v_x = _column(frame, speed)
        metrics |= {"v_x_min": v_x.min(), "v_x_max": v_x.max()}
    if _has(frame, yaw_rate) and len(frame["time"]) > 1:
        # The mean over each step, so that any plant can be compared.
        r_dot = np.diff(_column(frame, yaw_rate)) / np.diff(_column(frame, "time"))
        metrics |= {"r_dot_rms": _rms(r_dot), "r_dot_peak": np.abs(r_dot).max()}
    return {name: float(value) for name, value in metrics.items()}


def _acceleration(frame: Frame, buses: BusPaths) -> dict[str, float]:
    lateral = signal_path(buses, Motion, "a_y")
    return {"a_y_peak": float(np.abs(_column(frame, lateral)).max())} if _has(frame, lateral) else {}


def _tyres(frame: Frame, buses: BusPaths) -> dict[str, float]:
    shares = {share: signal_path(buses, Tyre, share) for share in ("mu_f", "mu_r")}
    return {f"{share}_max": float(_column(frame, name).max()) for share, name in shares.items() if _has(frame, name)}


def _actuation(frame: Frame, buses: BusPaths) -> dict[str, float]:
    name = signal_path(buses, Actuation, "delta_f")
    if not _has(frame, name):
        return {}
    delta, time = _column(frame, name), _column(frame, "time")
    return {"delta_f_rate_rms": _rms(np.diff(delta) / (time[-1] - time[-2])) if len(time) > 1 else 0.0}


def _path(frame: Frame, buses: BusPaths) -> dict[str, float]:
    error = _path_error(frame, buses)
    return {} if error is None else {"path_error_rms": _rms(error), "path_error_max": float(np.abs(error).max())}


def _corridor(frame: Frame, buses: BusPaths) -> dict[str, float]:
    y, upper, lower = (signal_path(buses, Plan, f"{signal}[1]") for signal in ("y", "y_upper", "y_lower"))
    if not _has(frame, y, upper, lower):
        return {}
    planned = _column(frame, y)
    outside = (planned > _column(frame, upper)) | (planned < _column(frame, lower))
    return {"corridor_violations": float(outside.sum())}


def _solver(frame: Frame, buses: BusPaths) -> dict[str, float]:
    metrics: dict[str, float] = {}
    if _has(frame, name := signal_path(buses, Solver, "status")):
        status = _column(frame, name)
        metrics["solver_limits"] = float((status == SolverStatus.iteration_limit).sum())
        metrics["solver_fallbacks"] = float((status == SolverStatus.fallback).sum())
    for signal in ("iterations", "kkt"):
        if _has(frame, name := signal_path(buses, Solver, signal)):
            metrics[f"solver_{signal}_max"] = float(_column(frame, name).max())
    return metrics


class Chosen(Mapping[str, Any]):
    """Some of the columns of a run, each of which is taken when it is asked for.

    Args:
        frame: All columns.
        names: Those that are wanted; those that are not there are left out.
        every: Only every how many rows are wanted.
    """

    def __init__(self, frame: Frame, names: Iterable[str], every: int = 1) -> None:
        self._frame, self._every = frame, every
        self._names = dict.fromkeys(name for name in names if name in frame)

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        values = self._frame[name]
        return values if self._every == 1 else values[:: self._every]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _column(frame: Frame, name: str) -> Array:
    return np.asarray(frame[name], dtype=float)


def _has(frame: Frame, *names: str) -> bool:
    """Whether all these columns were recorded."""
    return all(name in frame for name in names)


def _rms(values: NDArray[Any]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
