"""What happened in a run, as lines of a log at their tick: planned anew, lane change, fallback, near miss, limit.

Everything is read from recorded signals. Each kind of event is an edge: the row where something begins, not every row
in which it holds; what was so in the row before is kept from batch to batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.buses import SolverStatus
from orchestrator.pictures.drawing import Boxes
from orchestrator.pictures.plots import Limit
from orchestrator.pictures.shapes import Array, Memory
from orchestrator.pictures.signals import PATH, POSE, Cast, Recorded, SignalColumns
from orchestrator.results import geometry
from orchestrator.system.scene import Scene

PHASES: Final = ("own lane", "changing out", "adjacent lane", "changing back")
_PHASE_EVENTS: Final = {
    1: "lane change begun",
    2: "lane change finished",
    3: "return begun",
    0: "return finished",
}
_STATUS: Final = ("solver", "status")
_MOVED: Final = 1.0
"""[m] A lane change that moves by more is planned anew"""
_PAUSE: Final = 1.0
"""[s] between two lines about a plan that keeps moving"""
_AT_LIMIT: Final = 1 - 1e-9
"""Share of a limit that counts as reached"""
_NEAR: Final = 20.0
"""[m] between centres; boxes that are farther apart are not measured"""


@dataclass(frozen=True)
class Event:
    """One line of the log: in which row of the batch, what, and how bad (`INFO`, `WARN`, `ERROR`)."""

    row: int
    text: str
    level: str = "INFO"


def phases(columns: SignalColumns, who: Cast) -> NDArray[np.int64] | None:
    """Where the vehicle is on its path, as indices (n,) into `PHASES`; None without a vehicle or a path.

    The changes begin at P1 and P8 and end at P7 and P11 of the path as the controller saw it at the same instant; a
    path whose P7 lies in the own lane has none.
    """
    ego, path = columns.bus(who.plant, "state", "x"), columns.bus(who.controller, *PATH)
    if ego is None or path is None:
        return None
    x, y = path
    reached = (ego[0][:, None] >= x[:, [1, 7, 8, 11]]).sum(axis=1) % 4
    return np.where(np.abs(y[:, 7] - y[:, 1]) > 0.1, reached, 0).astype(np.int64)  # noqa: PLR2004 - [m]


def are_known(recorded: Recorded, who: Cast, scene: Scene | None, limits: list[Limit]) -> bool:
    """Whether there is anything recorded that events are read from."""
    if scene is not None and recorded.bus(who.plant, *POSE):
        return True
    if recorded.bus(who.controller, *PATH) or recorded.bus(who.controller, *_STATUS):
        return True
    return any(limit.binds for limit in limits)


class EventLog:
    """The events of one run, from batch to batch."""

    def __init__(self, who: Cast, scene: Scene | None, limits: list[Limit]) -> None:
        self._who, self._scene, self._limits = who, scene, limits
        self._memory = Memory()
        self._plan: Array | None = None
        self._told = -np.inf

    def of(self, columns: SignalColumns, boxes: Boxes | None) -> list[Event]:
        """The events of the rows that follow those of the last call, in order."""
        found = [
            *self._manoeuvre(columns),
            *self._replanned(columns),
            *self._solver(columns),
            *self._limit(columns),
            *(self._near(columns, boxes) if boxes is not None else ()),
            *self._edge(columns),
        ]
        return sorted(found, key=lambda event: event.row)

    def _manoeuvre(self, columns: SignalColumns) -> Iterator[Event]:
        phase = phases(columns, self._who)
        ego = columns.bus(self._who.plant, "state", "x")
        if phase is None or ego is None:
            return
        before = self._memory.before("phase", phase[:, None])[:, 0]
        for row in np.flatnonzero(phase != before):
            yield Event(int(row), f"{_PHASE_EVENTS[int(phase[row])]} at x = {ego[0][row]:.1f} m")

    def _replanned(self, columns: SignalColumns) -> Iterator[Event]:
        path = columns.bus(self._who.controller, *PATH)
        if path is None:
            return
        x, y = path
        plans = np.column_stack([x[:, [1, 8]], y[:, 7] - y[:, 1]])
        if self._plan is None:
            self._plan = plans[0]
        row = 0
        while row < len(plans):
            moved = (np.abs(plans[row:] - self._plan) > _MOVED).any(axis=1)
            moved &= columns.time[row:] >= self._told + _PAUSE
            if not moved.any():
                return
            row += int(np.argmax(moved))
            yield Event(row, _plan_text(plans[row]))
            self._plan, self._told = plans[row], float(columns.time[row])

    def _solver(self, columns: SignalColumns) -> Iterator[Event]:
        found = columns.bus(self._who.controller, *_STATUS)
        if found is None:
            return
        for status, text, level in (
            (SolverStatus.iteration_limit, "solver: iteration limit, not converged", "WARN"),
            (SolverStatus.fallback, "solver: fallback, the previous plan is followed", "ERROR"),
        ):
            for row in self._memory.begins(f"solver {status}", found[0] == status):
                yield Event(int(row), text, level)

    def _limit(self, columns: SignalColumns) -> Iterator[Event]:
        for limit in (x for x in self._limits if x.binds and columns.has(x.signal)):
            values, side = columns.of(limit.signal), np.sign(limit.value)
            holds = side * values >= side * limit.value * _AT_LIMIT
            for row in self._memory.begins(f"limit {limit.signal} {limit.label}", holds & (limit.value != 0)):
                yield Event(int(row), _limit_text(limit), "WARN")

    def _near(self, columns: SignalColumns, boxes: Boxes) -> Iterator[Event]:
        ego = columns.bus(self._who.plant, *POSE)
        if ego is None or self._scene is None:
            return
        x, y, psi = (values[boxes.row] for values in ego)
        close = np.hypot(boxes.x - x, boxes.y - y) < _NEAR
        size = np.tile([self._scene.ego_length, self._scene.ego_width], (int(close.sum()), 1))
        own = np.column_stack([x[close], y[close], psi[close], size])
        other = np.column_stack([boxes.x, boxes.y, boxes.psi, boxes.length, boxes.width])[close]
        gap, row = geometry.box_distance(own, other), boxes.row[close]
        nearest, identity = np.full(len(columns.time), np.inf), np.zeros(len(columns.time), dtype=np.int64)
        falling = np.argsort(-gap, kind="stable")  # of several boxes in a row, the nearest is written last
        nearest[row[falling]], identity[row[falling]] = gap[falling], boxes.id[close][falling]
        for row in self._memory.begins("near", (nearest > 0) & (nearest < self._scene.l_gap)):
            yield Event(int(row), f"near miss: {nearest[row]:.2f} m to #{identity[row]}", "WARN")
        for row in self._memory.begins("contact", nearest <= 0):
            yield Event(int(row), f"contact with #{identity[row]}", "ERROR")

    def _edge(self, columns: SignalColumns) -> Iterator[Event]:
        ego = columns.bus(self._who.plant, *POSE)
        if ego is None or self._scene is None:
            return
        size = np.tile([self._scene.ego_length, self._scene.ego_width], (len(ego[0]), 1))
        y = geometry.box_corners(np.column_stack([*ego, size]))[:, :, 1]
        gap = np.minimum(self._scene.y_left - y.max(axis=1), y.min(axis=1) - self._scene.y_right)
        for row in self._memory.begins("edge", gap < 0):
            yield Event(int(row), f"off the road by {-gap[row]:.2f} m", "ERROR")


def _limit_text(limit: Limit) -> str:
    unit = limit.label.partition("[")[2].rstrip("]")
    text = f"limit active: {limit.signal.rpartition('.')[2]} at {limit.value:.4g}"
    return text if unit in {"", "1"} else f"{text} {unit}"


def _plan_text(plan: Array) -> str:
    x_out, x_back, across = (float(v) for v in plan)
    if abs(across) <= 0.1:  # noqa: PLR2004 - [m]
        return "replanned: no lane change"
    return f"replanned: lane change from x = {x_out:.1f} m, return from x = {x_back:.1f} m"
