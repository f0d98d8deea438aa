"""Whether a vehicle has done what it was on the road for: it has passed who is slower, is in its lane, and at speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from components import BLOCKS
from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from orchestrator.results.metrics import Frame, columns
from orchestrator.system.scene import Scene
from orchestrator.system.shown import BusPaths, signal_path

IN_LANE: Final = 0.5
"""[m] The largest distance from the centre of the own lane at which a vehicle is back in it."""
_AS_ASKED: Final = (0.8, 1.25)
"""Shares of the speed that was asked for between which nothing is said of the start."""
AT_SPEED: Final = 0.9
"""The least share of the speed that was asked for at which a vehicle is at speed."""


def task(rows: Frame, buses: BusPaths, scene: Scene, v_ref: float | None, until: int | None = None) -> dict[str, float]:
    """The metrics of the task.

    Those who stand or drive in the own lane ahead of the vehicle at the start, and whom it would have reached by the
    end at the speed that was asked for, are to be passed: `obstacles_to_pass` counts them, `obstacles_passed` those of
    them that are behind it at the end. `lane_offset_end` is the distance [m] from the centre of the own lane at the
    end, `speed_share_end` the share of the speed that was asked for, `speed_share_start` that at the start.

    Args:
        rows: Rows of consecutive ticks.
        buses: The path of each output bus of the system.
        scene: The road.
        v_ref: The speed [m/s] that the controller was asked for; where it is not known, the largest of the run.
        until: The row from which on nobody looks at the vehicle, where there is one.
    """
    paths = [signal_path(buses, VehicleState, name) for name in ("x", "y", "v_x")]
    if not all(path in rows for path in paths):
        return {}
    ego = np.stack([np.asarray(rows[path], dtype=float) for path in paths])
    finite = np.flatnonzero(np.isfinite(ego[:, :until]).all(axis=0))
    if not len(finite):
        return {}
    (x_start, _, v_start), (x_end, y_end, v_end) = ego[:, finite[0]], ego[:, finite[-1]]
    speed = v_ref or float(np.max(ego[2, finite]))
    found = {"lane_offset_end": abs(y_end - scene.y_lane), "speed_share_end": v_end / speed if speed > 0 else 0.0}
    if v_ref:
        found["speed_share_start"] = v_start / v_ref
    if signal_path(buses, ObstacleList, f"x[{SLOTS}]") in rows:
        x, y, valid = (columns(rows, signal_path(buses, ObstacleList, name), SLOTS) for name in ("x", "y", "valid"))
        first, last = finite[0], finite[-1]
        reached = x_start + speed * float(rows["time"][last] - rows["time"][first])
        own = np.abs(y[first] - scene.y_lane) < abs(scene.y_adjacent - scene.y_lane) / 2
        met = (valid[first] > 0) & (valid[last] > 0) & own & (x[first] > x_start) & (x[last] < reached)
        found["obstacles_to_pass"] = float(met.sum())
        found["obstacles_passed"] = float((met & (x[last] < x_end)).sum())
    return {name: float(value) for name, value in found.items() if np.isfinite(value)}


def is_done(metrics: Mapping[str, float]) -> dict[str, bool]:
    """The verdict `task_done`, where the metrics of the task allow it."""
    if not {"lane_offset_end", "speed_share_end"} <= metrics.keys():
        return {}
    passed = metrics.get("obstacles_passed", 0) == metrics.get("obstacles_to_pass", 0)
    back = metrics["lane_offset_end"] <= IN_LANE
    return {"task_done": bool(passed and back and metrics["speed_share_end"] >= AT_SPEED)}


def start_remarks(metrics: Mapping[str, float], plant: str | None, kind: str) -> list[str]:
    """A remark where the vehicle of another maker starts at another speed than its controller is asked for.

    Args:
        metrics: The metrics of the task.
        plant: The unit that shows the vehicle.
        kind: What it is; the blocks of the catalogue start as their parameters say, which a person sees.
    """
    share = metrics.get("speed_share_start", 1.0)
    if plant is None or kind in BLOCKS or _AS_ASKED[0] <= share <= _AS_ASKED[1]:
        return []
    asked = f"`{plant}` starts at {share:.0%} of the speed that its controller is asked for (`v_ref`)"
    return [f"{asked}; start values of the scenario's own plant do not count; --set {plant}.NAME=VALUE sets its own"]
