"""Whether a vehicle has done what it was on the road for: it has passed who is slower, is in its lane, and at speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from components import BLOCKS
from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from orchestrator.results.metrics import Frame, columns
from orchestrator.results.sightings import identities, sightings
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

    Those who stand or drive in the own lane ahead of the vehicle when they are first seen, and whom it would have
    reached by the time they are last seen at the speed that was asked for, are to be passed: `obstacles_to_pass` counts
    them, `obstacles_passed` those of them that are behind it when they are last seen. `lane_offset_end` is the distance
    [m] from the centre of the own lane at the end, `speed_share_end` the share of the speed that was asked for,
    `speed_share_start` that at the start.

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
    v_start, (_, y_end, v_end) = ego[2, finite[0]], ego[:, finite[-1]]
    speed = v_ref or float(np.max(ego[2, finite]))
    found = {"lane_offset_end": abs(y_end - scene.y_lane), "speed_share_end": v_end / speed if speed > 0 else 0.0}
    if v_ref:
        found["speed_share_start"] = v_start / v_ref
    found |= _passed(rows, buses, scene, finite, speed)
    return {name: float(value) for name, value in found.items() if np.isfinite(value)}


def _passed(rows: Frame, buses: BusPaths, scene: Scene, finite: NDArray[np.int64], speed: float) -> dict[str, float]:
    """How many obstacles are to be passed, and how many of them are; nothing where the traffic is not known."""
    paths = [signal_path(buses, ObstacleList, name) for name in ("valid", "id", "x", "y")]
    if not all(f"{path}[{SLOTS}]" in rows for path in paths):
        return {}
    valid, identity, x, y = (columns(rows, path, SLOTS)[finite] for path in paths)
    seen = valid > 0
    row, _ = np.nonzero(seen)
    ego = np.asarray(rows[signal_path(buses, VehicleState, "x")], dtype=float)[finite]
    time = np.asarray(rows["time"], dtype=float)[finite]
    reached = ego[0] + speed * (time - time[0])
    first, last = sightings(identities(seen, identity)[seen])
    x, y = x[seen], y[seen]
    own = np.abs(y[first] - scene.y_lane) < abs(scene.y_adjacent - scene.y_lane) / 2
    met = own & (x[first] > ego[row[first]]) & (x[last] < reached[row[last]])
    passed = met & (x[last] < ego[row[last]])
    return {"obstacles_to_pass": float(met.sum()), "obstacles_passed": float(passed.sum())}


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
