"""What happened in a run, as lines of a log: new plans, lane changes, failures of the solver, limits, near misses.

Everything is read from recorded signals. An event is an edge: the row where a condition begins to hold, not every row
in which it holds. The state of each condition is kept from batch to batch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.buses import Solver, SolverStatus, VehicleState
from components.interfaces.maths import Array
from orchestrator.pictures.drawing import Nearest, ego_boxes
from orchestrator.pictures.plots import Limit
from orchestrator.pictures.shapes import Memory
from orchestrator.pictures.signals import PATH_SIGNALS, POSE_SIGNALS, Recorded, SignalColumns
from orchestrator.results.departure import in_surroundings
from orchestrator.results.metrics import edge_gap
from orchestrator.system.scene import Scene
from orchestrator.system.shown import BusPaths

PHASES: Final = ("own lane", "changing out", "adjacent lane", "changing back", "third lane")
_ADJACENT, _THIRD = 2, 4
_PHASE_EVENTS: Final = {
    1: "lane change begun",
    2: "lane change finished",
    3: "return begun",
    0: "return finished",
    4: "lane change to the third lane finished",
}
_STATUS_SIGNALS: Final = (Solver, "status")
_MOVED: Final = 1.0
"""[m] A lane change that moves by more than this is a new plan."""
_PAUSE: Final = 1.0
"""[s] Least time between two lines about a plan that keeps moving, or about a limit that is left and met again."""
_AT_LIMIT: Final = 1 - 1e-9
"""Share of a limit that counts as reached."""


@dataclass(frozen=True)
class Event:
    """One line of the log."""

    row: int
    """Its row in the batch."""
    text: str
    level: str = "INFO"
    """`INFO`, `WARN` or `ERROR`."""


def phases(columns: SignalColumns, buses: BusPaths, scene: Scene | None) -> NDArray[np.int64] | None:
    """The phase of the lane change in every row.

    The changes begin at P1 and P8 and end at P7 and P11 of the path as the controller saw it at the same instant; a
    path whose P7 lies in the own lane has no lane change.

    Args:
        columns: The rows of a run.
        buses: The buses of its system.
        scene: The road, which tells the adjacent lane from the third.

    Returns:
        Indices into `PHASES`, `(n,)`; None where the vehicle or the path was not recorded.
    """
    ego, path = columns.bus(buses, VehicleState, "x"), columns.bus(buses, *PATH_SIGNALS)
    if ego is None or path is None:
        return None
    x, y = path
    reached = (ego[0][:, None] >= x[:, [1, 7, 8, 11]]).sum(axis=1) % 4
    phase = np.where(np.abs(y[:, 7] - y[:, 1]) > 0.1, reached, 0)  # noqa: PLR2004 - [m]
    if scene is not None:
        in_third = np.abs(y[:, 7] - scene.y_third) < np.abs(y[:, 7] - scene.y_adjacent)
        phase = np.where((phase == _ADJACENT) & in_third, _THIRD, phase)
    return phase.astype(np.int64)


def are_known(recorded: Recorded, buses: BusPaths, scene: Scene | None, limits: Sequence[Limit]) -> bool:
    """Whether anything is recorded that events are read from.

    Args:
        recorded: What is recorded of a run.
        buses: The buses of its system.
        scene: The scene that it is drawn in.
        limits: The limits of its signals.
    """
    if scene is not None and recorded.bus(buses, *POSE_SIGNALS):
        return True
    if recorded.bus(buses, *PATH_SIGNALS) or recorded.bus(buses, *_STATUS_SIGNALS):
        return True
    return any(limit.binds for limit in limits)


class EventLog:
    """The events of one run, from batch to batch.

    Args:
        buses: The buses of its system.
        scene: The scene that it is drawn in; without one there are no events of the road and the traffic.
        limits: The limits of its signals.
    """

    def __init__(self, buses: BusPaths, scene: Scene | None, limits: Sequence[Limit]) -> None:
        self._buses, self._scene, self._limits = buses, scene, limits
        self._memory = Memory()
        self._plan: Array | None = None
        """What the last line about a plan said, or the plan at the start."""
        self._held: dict[str, float] = {}
        """[s] The last time at which each condition held."""
        self._plan_time = -np.inf
        """[s] The time of the last line about a plan."""

    def of(self, columns: SignalColumns, near: Nearest | None) -> list[Event]:
        """The events of a batch.

        Args:
            columns: The rows that follow those of the last call.
            near: The nearest obstacle in these rows; None where it is not known.

        Returns:
            The events in the order of their rows.
        """
        events = [
            *self._manoeuvre(columns),
            *self._replanned(columns),
            *self._solver(columns),
            *self._limit(columns),
            *(self._near(near, self._scene) if near is not None and self._scene is not None else ()),
            *self._edge(columns),
        ]
        return sorted(events, key=lambda event: event.row)

    def _manoeuvre(self, columns: SignalColumns) -> Iterator[Event]:
        phase = phases(columns, self._buses, self._scene)
        ego = columns.bus(self._buses, VehicleState, "x")
        if phase is None or ego is None:
            return
        before = self._memory.before("phase", phase[:, None])[:, 0]
        for row in np.flatnonzero(phase != before):
            yield Event(int(row), f"{_PHASE_EVENTS[int(phase[row])]} at x = {ego[0][row]:.1f} m")

    def _replanned(self, columns: SignalColumns) -> Iterator[Event]:
        path = columns.bus(self._buses, *PATH_SIGNALS)
        if path is None:
            return
        x, y = path
        plans = np.column_stack([x[:, [1, 8]], y[:, 7] - y[:, 1]])
        if self._plan is None:
            self._plan = plans[0]
        row = 0
        while row < len(plans):
            moved = (np.abs(plans[row:] - self._plan) > _MOVED).any(axis=1)
            moved &= columns.time[row:] >= self._plan_time + _PAUSE
            if not moved.any():
                return
            row += int(np.argmax(moved))
            yield Event(row, _plan_text(plans[row]))
            self._plan, self._plan_time = plans[row], float(columns.time[row])

    def _solver(self, columns: SignalColumns) -> Iterator[Event]:
        status = columns.bus(self._buses, *_STATUS_SIGNALS)
        if status is None:
            return
        for failure, text, level in (
            (SolverStatus.iteration_limit, "solver: iteration limit, not converged", "WARN"),
            (SolverStatus.fallback, "solver: fallback, the previous plan is followed", "ERROR"),
        ):
            for row in self._memory.begins(f"solver {failure}", status[0] == failure):
                yield Event(int(row), text, level)

    def _limit(self, columns: SignalColumns) -> Iterator[Event]:
        for limit in (x for x in self._limits if x.binds and columns.has(x.signal.path)):
            values, side = columns.of(limit.signal.path), np.sign(limit.value)
            holds = side * values >= side * limit.value * _AT_LIMIT
            for row in self._stretches(f"limit {limit.signal.path} {limit.name}", holds & (limit.value != 0), columns):
                yield Event(int(row), _limit_text(limit), "WARN")

    def _stretches(self, at: str, holds: NDArray[np.bool_], columns: SignalColumns) -> Iterator[int]:
        """The rows where a condition begins to hold, unless it has held less than `_PAUSE` before."""
        begins = self._memory.begins(at, holds)
        held = columns.time[holds]
        for row in begins:
            earlier = held[held < columns.time[row]]
            last = earlier[-1] if len(earlier) else self._held.get(at, -np.inf)
            if columns.time[row] - last > _PAUSE:
                yield int(row)
        if len(held):
            self._held[at] = float(held[-1])

    def _near(self, near: Nearest, scene: Scene) -> Iterator[Event]:
        gap, identity = near
        for row in self._memory.begins("near", (gap > 0) & (gap < scene.l_gap)):
            yield Event(int(row), f"near miss: {gap[row]:.2f} m to #{identity[row]}", "WARN")
        for row in self._memory.begins("contact", gap <= 0):
            yield Event(int(row), f"contact with #{identity[row]}", "ERROR")

    def _edge(self, columns: SignalColumns) -> Iterator[Event]:
        ego = None if self._scene is None else ego_boxes(columns, self._buses, self._scene)
        if ego is None or self._scene is None:
            return
        gap = edge_gap(ego, self._scene)
        for row in self._memory.begins("edge", gap < 0):
            yield Event(int(row), f"off the road by {-gap[row]:.2f} m", "ERROR")
        for row in self._memory.begins("surroundings", ~in_surroundings(ego[:, 0], ego[:, 1], self._scene)):
            yield Event(int(row), f"left the surroundings of the road at y = {ego[row, 1]:.3g} m", "ERROR")


def _limit_text(limit: Limit) -> str:
    text = f"limit active: {limit.signal.name} at {limit.value:.4g}"
    return text if limit.unit in {"", "1"} else f"{text} {limit.unit}"


def _plan_text(plan: Array) -> str:
    x_out, x_back, across = (float(v) for v in plan)
    if abs(across) <= 0.1:  # noqa: PLR2004 - [m]
        return "replanned: no lane change"
    return f"replanned: lane change from x = {x_out:.1f} m, return from x = {x_back:.1f} m"
