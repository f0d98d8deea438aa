"""The evidence that decides claims: metrics of runs, curves of gains, distances of trajectories, times per sample."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pandas as pd

from components.interfaces.buses import WAYPOINTS, VehicleState, Waypoints
from components.interfaces.maths import Array
from orchestrator.reproduction.paper.experiments import Experiments, RunPlan, RunRole
from orchestrator.reproduction.paper.verdict import DecidingNumber
from orchestrator.reproduction.runs import Outcome
from orchestrator.results import metrics
from orchestrator.results.path_geometry import path_error
from orchestrator.system.shown import BusPaths, signal_path

SWING: Final = 0.05
"""[rad/s] Yaw rates below this are no swing: a tenth of the 0.49 rad/s that the path demands, R = v^2/(mu g)."""

IN_PROCESS: Final = "in this process"
AS_FMU: Final = "FMU"
"""How a controller runs while it is timed."""

TUNED: Final = "MP tuned"
"""The setting of the paper's method that `plus` runs are compared with."""

TYRES: Final = {"bicycle": "linear", "bicycle_saturated": "saturating"}
"""The tyre of a plant, as conditions call it."""


@dataclass(frozen=True)
class Result:
    """The metrics of one run, and its part among the experiments."""

    name: str
    task: str
    plant: str
    controller: str
    role: RunRole
    label: str
    metrics: Mapping[str, float]
    finished: bool = True

    @property
    def tyre(self) -> str:
        """The tyre of the plant as conditions call it; the plant's name where none is known."""
        return TYRES.get(self.plant, self.plant)

    def numbers(self, *metrics: str, of: str = "") -> tuple[DecidingNumber, ...]:
        """Those of these metrics that the run has, as numbers of a case; `of` as in `DecidingNumber`."""
        return tuple(DecidingNumber(name, self.metrics[name], of) for name in metrics if name in self.metrics)


@dataclass(frozen=True)
class Curve:
    """The results of a sweep, in the order of its values."""

    name: str
    task: str
    plant: str
    label: str
    points: tuple[Result, ...]


@dataclass(frozen=True)
class Timing:
    """Wall time of one sample of a controller, path planning included."""

    controller: str
    way: str
    """`IN_PROCESS` or `AS_FMU`."""
    p50_us: float
    p99_us: float
    ratio_p50: float
    """The ratio of the p50 to that of the controller that the list of experiments names."""
    ratio_p99: float


@dataclass(frozen=True)
class Evidence:
    """Everything that claims may be decided by."""

    results: tuple[Result, ...]
    curves: tuple[Curve, ...] = ()
    distances: Mapping[str, float] = field(default_factory=dict[str, float])
    """Largest distance [m] of the trajectory of another algorithm from that of the `reference` run, by run."""
    off_path: Mapping[str, float] = field(default_factory=dict[str, float])
    """rms distance [m] of a `plus` run from the path of the paper's method, by run: its own path may differ."""
    timings: tuple[Timing, ...] = ()
    reference: str = ""
    """The run that other algorithms are compared with."""

    def of(self, role: RunRole, like: Result | None = None) -> list[Result]:
        """The results of a role; with `like`, only those of the same task and plant as that result."""
        return [
            r for r in self.results if r.role is role and (like is None or (r.task, r.plant) == (like.task, like.plant))
        ]

    def curves_for(self, result: Result) -> list[Curve]:
        """The curves of the same task and plant."""
        return [c for c in self.curves if (c.task, c.plant) == (result.task, result.plant)]


@dataclass(frozen=True)
class RecordedRun:
    """The rows of a run, with the buses of its system."""

    frame: pd.DataFrame
    """`time`, and a column for each element of a signal."""
    buses: BusPaths

    def state(self, signal: str) -> Array:
        """A signal of the vehicle's state, `(n,)`."""
        return self.frame[signal_path(self.buses, VehicleState, signal)].to_numpy(float)

    def path(self, axis: str) -> Array:
        """A coordinate of the waypoints of the path, `(n, WAYPOINTS)`."""
        return metrics.columns(self.frame, signal_path(self.buses, Waypoints, axis), WAYPOINTS)


def result(run: RunPlan, measured: Mapping[str, float], recorded: RecordedRun, *, finished: bool) -> Result:
    """The result of a run.

    Args:
        run: The run as it was planned.
        measured: The metrics of its summary.
        recorded: Its rows, for the metrics that only claims need.
        finished: Whether it came to its end without a fault.
    """
    values = {**measured, **more_metrics(recorded)}
    return Result(run.name, run.task, run.plant, run.controller, run.role, run.label, values, finished=finished)


def more_metrics(recorded: RecordedRun) -> dict[str, float]:
    """The metrics that claims need beyond those of every run."""
    return {"r_sign_changes": float(sign_changes(recorded.state("r")))}


def gather(experiments: Experiments, outcomes: Mapping[str, Outcome], timings: Sequence[Timing]) -> Evidence:
    """Read the evidence from the run folders.

    Args:
        experiments: The list of experiments.
        outcomes: The executed runs by name.
        timings: The times per sample, where they were measured.
    """
    recorded = {name: RecordedRun(outcome.rows(), outcome.buses) for name, outcome in outcomes.items()}
    results: dict[str, Result] = {}
    for name, outcome in outcomes.items():
        summary = outcome.summary
        finished = summary["status"] == "finished"
        results[name] = result(outcome.run, summary["metrics"], recorded[name], finished=finished)
    curves = tuple(
        Curve(s.name, s.task, s.plant, s.label, tuple(results[run.name] for run in s.runs()))
        for s in experiments.sweeps
    )
    distances: dict[str, float] = {}
    reference = experiments.timing.states if experiments.timing is not None else ""
    if reference:
        alike = [run for run in experiments.runs if run.role in {RunRole.ALGORITHM, RunRole.LOOSE}]
        distances = {run.name: trajectory_distance(recorded[reference], recorded[run.name]) for run in alike}
    return Evidence(
        results=tuple(results[run.name] for run in experiments.runs),
        curves=curves,
        distances=distances,
        off_path=dict(_off_paths(experiments, recorded)),
        timings=tuple(timings),
        reference=reference,
    )


def _off_paths(experiments: Experiments, recorded: Mapping[str, RecordedRun]) -> Iterator[tuple[str, float]]:
    for plus in (run for run in experiments.runs if run.role is RunRole.PLUS):
        for mp in (run for run in experiments.runs if run.role is RunRole.MP and run.label == TUNED):
            if (mp.task, mp.plant) == (plus.task, plus.plant):
                yield plus.name, off_path(recorded[plus.name], recorded[mp.name])


def off_path(run: RecordedRun, leader: RecordedRun) -> float:
    """Distance [m], rms, of a vehicle from the path that the controller of another run plans at the same instant."""
    n = min(len(run.frame), len(leader.frame))
    x, y = (run.state(axis)[:n] for axis in "xy")
    path_x, path_y = (leader.path(axis)[:n] for axis in "xy")
    return float(np.sqrt(np.mean(np.square(path_error(path_x, path_y, x, y)))))


def sign_changes(r: Array) -> int:
    """How often the yaw rate swings from one side to the other.

    Args:
        r: The yaw rate [rad/s], `(n,)`; values below `SWING` do not count.
    """
    swings = np.sign(r[np.abs(r) > SWING])
    return int((swings[1:] != swings[:-1]).sum())


def trajectory_distance(a: RecordedRun, b: RecordedRun) -> float:
    """Largest distance [m] between the vehicles of two runs at the same instant."""
    n = min(len(a.frame), len(b.frame))
    dx, dy = (a.state(axis)[:n] - b.state(axis)[:n] for axis in "xy")
    return float(np.hypot(dx, dy).max())
