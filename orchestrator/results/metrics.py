"""Metrics of a run, computed from its rows alone, and the plain verdicts on them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.buses import SLOTS, WAYPOINTS, SolverStatus
from orchestrator.results import path_geometry
from orchestrator.results.geometry import Rows, box_corners, box_distance
from orchestrator.system.scene import Scene

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

Frame: TypeAlias = "pd.DataFrame | Mapping[str, NDArray[Any]]"
"""A column of rows for each signal element, and `time`"""

_BOX = ("x", "y", "psi", "length", "width")
"""What a box is given by"""


def compute(frame: Frame, roles: Mapping[str, str], scene: Scene) -> dict[str, float]:
    """All metrics that the columns of `frame` allow, whose rows are consecutive ticks.

    `roles` names the unit in each socket. SI units; `gap_obstacle` is the least distance between the ego's box and any
    obstacle's (0 on contact), `gap_edge` between the ego's corners and the road's edges (negative outside). Rows with
    values that are not finite (the last one of a run that broke) do not count.
    """
    frame = _finite(frame)
    found: dict[str, float] = {}
    if not len(frame["time"]):
        return found
    plant, traffic, controller = (roles.get(role, "") for role in ("plant", "traffic", "controller"))
    found |= _motion(frame, plant) | _tyres(frame, plant)
    placed = _has(frame, f"{plant}.state.x", f"{plant}.state.y", f"{plant}.state.psi")
    if placed:
        found["gap_edge"] = float(edge_gap(ego_boxes(frame, plant, scene), scene).min())
    if placed and _has(frame, *(f"{traffic}.obstacles.{s}[{SLOTS}]" for s in ("valid", *_BOX))):
        found["gap_obstacle"] = float(obstacle_gaps(frame, roles, scene).min())
    found |= _actuation(frame, controller) | _planning(frame, plant, controller) | _solver(frame, controller)
    return {name: value for name, value in found.items() if np.isfinite(value)}


def verdicts(metrics: Mapping[str, float]) -> dict[str, bool]:
    """What a person asks first of a run."""
    found: dict[str, bool] = {}
    if "gap_obstacle" in metrics:
        found["no_contact"] = metrics["gap_obstacle"] > 0
    if "gap_edge" in metrics:
        found["inside_road"] = metrics["gap_edge"] >= 0
    if "mu_f_max" in metrics:
        found["within_friction_limit"] = max(metrics["mu_f_max"], metrics["mu_r_max"]) <= 1
    if {"solver_fallbacks", "solver_limits"} <= metrics.keys():
        found["solver_converged"] = metrics["solver_fallbacks"] == 0 and metrics["solver_limits"] == 0
    return found


def columns(frame: Frame, prefix: str, n: int) -> NDArray[np.float64]:
    """The elements ``prefix[1]`` to ``prefix[n]``, of shape (rows, n)."""
    return np.stack([_column(frame, f"{prefix}[{i + 1}]") for i in range(n)], axis=1)


def ego_boxes(frame: Frame, plant: str, scene: Scene) -> NDArray[np.float64]:
    """The ego's box in every row: x, y, psi, length, width."""
    pose = np.stack([_column(frame, f"{plant}.state.{s}") for s in ("x", "y", "psi")], axis=1)
    size = np.tile([scene.ego_length, scene.ego_width], (len(pose), 1))
    return np.hstack([pose, size])


def edge_gap(boxes: NDArray[np.float64], scene: Scene) -> Rows:
    """Least distance [m] of each box's corners to the road's edges; negative outside."""
    y = box_corners(boxes)[:, :, 1]
    return np.minimum(scene.y_left - y.max(axis=1), y.min(axis=1) - scene.y_right)


def obstacle_gaps(frame: Frame, roles: Mapping[str, str], scene: Scene) -> Rows:
    """Least distance [m] of the ego's box to any valid obstacle's, in every row; infinite without obstacles."""
    ego = ego_boxes(frame, roles["plant"], scene)
    bus = f"{roles['traffic']}.obstacles"
    valid = columns(frame, f"{bus}.valid", SLOTS) > 0
    parts = [columns(frame, f"{bus}.{s}", SLOTS) for s in _BOX]
    nearest = np.full(len(ego), np.inf)
    for slot in np.flatnonzero(valid.any(axis=0)):
        here = valid[:, slot]
        boxes = np.stack([part[here, slot] for part in parts], axis=1)
        nearest[here] = np.minimum(nearest[here], box_distance(ego[here], boxes))
    return nearest


def path_error(frame: Frame, plant: str, controller: str) -> Rows | None:
    """Distance [m] of the centre of gravity to the path of the same row, positive to the left of it.

    None where the controller shows no path, or one of both was not recorded.
    """
    axes = [f"{plant}.state.{axis}" for axis in "xy"] + [f"{controller}.path.{axis}[{WAYPOINTS}]" for axis in "xy"]
    if not _has(frame, *axes):
        return None
    x, y = _column(frame, f"{plant}.state.x"), _column(frame, f"{plant}.state.y")
    path_x, path_y = (columns(frame, f"{controller}.path.{axis}", WAYPOINTS) for axis in "xy")
    return path_geometry.path_error(path_x, path_y, x, y)


def _motion(frame: Frame, plant: str) -> dict[str, float]:
    found: dict[str, Any] = {}
    if _has(frame, f"{plant}.state.r"):
        r = _column(frame, f"{plant}.state.r")
        found |= {"r_peak": np.abs(r).max(), "r_rms": _rms(r), "r_total_variation": np.abs(np.diff(r)).sum()}
    if _has(frame, f"{plant}.state.v_x"):
        v_x = _column(frame, f"{plant}.state.v_x")
        found |= {"v_x_min": v_x.min(), "v_x_max": v_x.max()}
    if _has(frame, f"{plant}.state.r") and len(frame["time"]) > 1:
        # the mean over each step, so that any plant can be compared
        r_dot = np.diff(_column(frame, f"{plant}.state.r")) / np.diff(_column(frame, "time"))
        found |= {"r_dot_rms": _rms(r_dot), "r_dot_peak": np.abs(r_dot).max()}
    if _has(frame, f"{plant}.motion.a_y"):
        found["a_y_peak"] = np.abs(_column(frame, f"{plant}.motion.a_y")).max()
    return {name: float(value) for name, value in found.items()}


def _tyres(frame: Frame, plant: str) -> dict[str, float]:
    names = [n for n in ("mu_f", "mu_r") if _has(frame, f"{plant}.tyre.{n}")]
    return {f"{n}_max": float(_column(frame, f"{plant}.tyre.{n}").max()) for n in names}


def _actuation(frame: Frame, controller: str) -> dict[str, float]:
    if not _has(frame, f"{controller}.actuation.delta_f"):
        return {}
    delta, time = _column(frame, f"{controller}.actuation.delta_f"), _column(frame, "time")
    return {"delta_f_rate_rms": _rms(np.diff(delta) / (time[-1] - time[-2])) if len(time) > 1 else 0.0}


def _planning(frame: Frame, plant: str, controller: str) -> dict[str, float]:
    found: dict[str, float] = {}
    error = path_error(frame, plant, controller)
    if error is not None:
        found |= {"path_error_rms": _rms(error), "path_error_max": float(np.abs(error).max())}
    y, upper, lower = (f"{controller}.plan.{s}[1]" for s in ("y", "y_upper", "y_lower"))
    if _has(frame, y, upper, lower):
        planned = _column(frame, y)
        outside = (planned > _column(frame, upper)) | (planned < _column(frame, lower))
        found["corridor_violations"] = float(outside.sum())
    return found


def _solver(frame: Frame, controller: str) -> dict[str, float]:
    found: dict[str, float] = {}
    if _has(frame, f"{controller}.solver.status"):
        status = _column(frame, f"{controller}.solver.status")
        found["solver_limits"] = float((status == SolverStatus.iteration_limit).sum())
        found["solver_fallbacks"] = float((status == SolverStatus.fallback).sum())
    for name in ("iterations", "kkt"):
        if _has(frame, f"{controller}.solver.{name}"):
            found[f"solver_{name}_max"] = float(_column(frame, f"{controller}.solver.{name}").max())
    return found


def _finite(frame: Frame) -> dict[str, NDArray[Any]]:
    """The rows in which all numbers are finite."""
    whole = {name: np.asarray(frame[name]) for name in map(str, frame)}
    finite = np.ones(len(whole["time"]), dtype=bool)
    for values in whole.values():
        if values.dtype.kind == "f":  # others are always finite, or no numbers
            finite &= np.isfinite(values)
    return {name: values[finite] for name, values in whole.items()}


def _column(frame: Frame, name: str) -> NDArray[np.float64]:
    return np.asarray(frame[name], dtype=float)


def _has(frame: Frame, *names: str) -> bool:
    """Whether all these columns were recorded."""
    return all(name in frame for name in names)


def _rms(values: NDArray[Any]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
