"""The evidence that decides claims: metrics of runs, curves of gains, distances of trajectories, times per sample."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import pandas as pd

from components.interfaces.buses import WAYPOINTS
from orchestrator.reproduction.paper.experiments import Experiments, RunPlan, RunRole
from orchestrator.reproduction.paper.verdict import DecidingNumber
from orchestrator.reproduction.runs import Outcome
from orchestrator.results import metrics
from orchestrator.results.path_geometry import path_error

SWING: Final = 0.05
"""[rad/s] Yaw rates below this are no swing: a tenth of the 0.49 rad/s that the path demands, R = v^2/(mu g)"""

IN_PROCESS: Final = "in this process"
AS_FMU: Final = "FMU"
"""How a controller runs while it is timed"""

TUNED: Final = "MP tuned"
"""The setting of the paper's method that `plus` runs are compared with"""

TYRES: Final = {"bicycle": "linear", "bicycle_saturated": "saturating"}
"""The tyre of a plant, as conditions call it"""


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
    """`IN_PROCESS` or `AS_FMU`"""
    p50_us: float
    p99_us: float
    ratio_p50: float
    """To the p50 of the controller that the list of experiments names"""
    ratio_p99: float


@dataclass(frozen=True)
class Evidence:
    """Everything that claims may be decided by."""

    results: tuple[Result, ...]
    curves: tuple[Curve, ...] = ()
    distances: Mapping[str, float] = field(default_factory=dict[str, float])
    """Largest distance [m] of the trajectory of another algorithm from that of the `reference` run, by run"""
    off_path: Mapping[str, float] = field(default_factory=dict[str, float])
    """rms distance [m] of a `plus` run from the path of the paper's method, by run: its own path may differ"""
    timings: tuple[Timing, ...] = ()
    reference: str = ""
    """The run that other algorithms are compared with"""

    def of(self, role: RunRole, like: Result | None = None) -> list[Result]:
        """The results of a role; with `like`, only those of the same task and plant as that result."""
        return [
            r for r in self.results if r.role is role and (like is None or (r.task, r.plant) == (like.task, like.plant))
        ]

    def curves_for(self, result: Result) -> list[Curve]:
        """The curves of the same task and plant."""
        return [c for c in self.curves if (c.task, c.plant) == (result.task, result.plant)]


def result(run: RunPlan, measured: Mapping[str, float], frame: pd.DataFrame, *, finished: bool) -> Result:
    """The metrics of a run, with those that only claims need."""
    found = {**measured, **more_metrics(frame)}
    return Result(run.name, run.task, run.plant, run.controller, run.role, run.label, found, finished=finished)


def more_metrics(frame: pd.DataFrame) -> dict[str, float]:
    """What claims need beyond the metrics of every run."""
    return {"r_sign_changes": float(sign_changes(frame["plant.state.r"].to_numpy(float)))}


def gather(experiments: Experiments, outcomes: Mapping[str, Outcome], timings: Sequence[Timing]) -> Evidence:
    """The evidence in the run folders."""
    frames = {name: pd.read_parquet(o.folder / "signals.parquet") for name, o in outcomes.items()}
    found: dict[str, Result] = {}
    for name, outcome in outcomes.items():
        told = outcome.summary
        found[name] = result(outcome.run, told["metrics"], frames[name], finished=told["status"] == "finished")
    curves = tuple(
        Curve(s.name, s.task, s.plant, s.label, tuple(found[run.name] for run in s.runs())) for s in experiments.sweeps
    )
    distances: dict[str, float] = {}
    reference = experiments.timing.states if experiments.timing is not None else ""
    if reference:
        alike = [run for run in experiments.runs if run.role in {RunRole.ALGORITHM, RunRole.LOOSE}]
        distances = {run.name: trajectory_distance(frames[reference], frames[run.name]) for run in alike}
    return Evidence(
        results=tuple(found[run.name] for run in experiments.runs),
        curves=curves,
        distances=distances,
        off_path=dict(_off_paths(experiments, frames)),
        timings=tuple(timings),
        reference=reference,
    )


def _off_paths(experiments: Experiments, frames: Mapping[str, pd.DataFrame]) -> Iterator[tuple[str, float]]:
    for plus in (run for run in experiments.runs if run.role is RunRole.PLUS):
        for mp in (run for run in experiments.runs if run.role is RunRole.MP and run.label == TUNED):
            if (mp.task, mp.plant) == (plus.task, plus.plant):
                yield plus.name, off_path(frames[plus.name], frames[mp.name])


def off_path(frame: pd.DataFrame, leader: pd.DataFrame) -> float:
    """Distance [m], rms, of a vehicle from the path that another run shows at the same instant."""
    n = min(len(frame), len(leader))
    x, y = (frame[f"plant.state.{axis}"].to_numpy(float)[:n] for axis in "xy")
    path_x, path_y = (metrics.columns(leader.iloc[:n], f"controller.path.{axis}", WAYPOINTS) for axis in "xy")
    return float(np.sqrt(np.mean(np.square(path_error(path_x, path_y, x, y)))))


def sign_changes(r: np.ndarray[tuple[int], np.dtype[np.float64]]) -> int:
    """How often the yaw rate swings to the other side, by `SWING` at least."""
    swings = np.sign(r[np.abs(r) > SWING])
    return int((swings[1:] != swings[:-1]).sum())


def trajectory_distance(a: pd.DataFrame, b: pd.DataFrame) -> float:
    """Largest distance [m] between two vehicles at the same instant."""
    n = min(len(a), len(b))
    dx, dy = (a[f"plant.state.{s}"].to_numpy(float)[:n] - b[f"plant.state.{s}"].to_numpy(float)[:n] for s in "xy")
    return float(np.hypot(dx, dy).max())
