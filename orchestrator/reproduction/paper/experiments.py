"""The list of experiments: which runs, sweeps and timings make up the reproduction; read from `experiments.toml`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import StrEnum
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict

from components import BLOCKS
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any
from orchestrator.scenario import scenario_file
from orchestrator.system.files import checked, read_toml

EXPERIMENTS: Final = Path(__file__).parent / "experiments.toml"


class RunRole(StrEnum):
    """The part of a run when claims are decided."""

    MP = "mp"
    """The paper's method."""
    TWO_LEVEL = "two_level"
    """The method that the paper compares it with."""
    ALGORITHM = "algorithm"
    """Another solver of the same problem."""
    LOOSE = "loose"
    """Another solver with a loose tolerance, for comparison only."""
    PLUS = "plus"
    """The controller that goes beyond the paper."""
    SWEEP = "sweep"
    """One point of a tracker's curve of gains."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class RunPlan(_Strict):
    """One run: a scenario, the blocks that replace its plant and its controller, and changed parameters."""

    name: str
    task: str
    scenario: str
    plant: str
    controller: str
    settings: tuple[str, ...] = ()
    """Changed parameters, written as for ``--set``."""
    role: RunRole
    label: str
    """What tables, figures and conditions call the run."""


class SweepPlan(_Strict):
    """The same run with several values of one parameter."""

    name: str
    task: str
    scenario: str
    plant: str
    controller: str
    parameter: str
    values: tuple[float, ...]
    unit: str
    label: str

    def runs(self) -> list[RunPlan]:
        """One run per value."""
        return [
            RunPlan(
                name=f"{self.name}-{value:g}",
                task=self.task,
                scenario=self.scenario,
                plant=self.plant,
                controller=self.controller,
                settings=(f"{self.parameter}={value!r}",),
                role=RunRole.SWEEP,
                label=f"{self.label}, {self.parameter.partition('.')[2]} = {value:g} {self.unit}",
            )
            for value in self.values
        ]


class TimingPlan(_Strict):
    """Which controllers are timed, and on which states."""

    states: str
    """The run whose recorded states all controllers are given."""
    controllers: tuple[str, ...]
    ratio_to: str
    """The controller that all times are related to."""


class FigureKind(StrEnum):
    """What a figure shows."""

    TRAJECTORY = "trajectory"
    YAW_RATE = "yaw_rate"
    DISTANCE = "distance"
    SMOOTHNESS = "smoothness"
    TIME = "time"


class ReportFigure(_Strict):
    """A figure of the report."""

    name: str
    kind: FigureKind
    runs: tuple[str, ...] = ()
    """The runs that it shows; none for the times per sample."""
    caption: str
    claims: tuple[str, ...] = ()
    """The claims that it illustrates: it stands with the first and is referred to from the others."""


class Experiments(_Strict):
    """All that `macrostep reproduce` runs."""

    runs: tuple[RunPlan, ...]
    sweeps: tuple[SweepPlan, ...] = ()
    timing: TimingPlan | None = None
    figures: tuple[ReportFigure, ...] = ()

    def all_runs(self) -> list[RunPlan]:
        """The runs, and those of the sweeps."""
        return [*self.runs, *(run for sweep in self.sweeps for run in sweep.runs())]


def load(path: Path = EXPERIMENTS) -> Experiments:
    """Read the list of experiments.

    Raises:
        RequestError: Names in the list are unknown or stand there twice; the error has all of them.
    """
    experiments = checked(Experiments, read_toml(path), path.name)
    raise_if_any(_problems(experiments, path.name))
    return experiments


def _problems(experiments: Experiments, where: str) -> Iterator[Problem]:
    names = [run.name for run in experiments.all_runs()]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield Problem(f"{where}: {name}", "two runs of this name", "one name for each run")
    for run in (*experiments.runs, *experiments.sweeps):
        yield from unknown(f"{where}: {run.name}", "scenario", run.scenario, scenario_file.names())
        yield from unknown(f"{where}: {run.name}", "block", run.plant, BLOCKS)
        yield from unknown(f"{where}: {run.name}", "block", run.controller, BLOCKS)
    for figure in experiments.figures:
        for name in figure.runs:
            yield from unknown(f"{where}: figure {figure.name}", "run", name, names)
    if (timing := experiments.timing) is not None:
        yield from unknown(f"{where}: timing.states", "run", timing.states, names)
        yield from unknown(f"{where}: timing.ratio_to", "controller", timing.ratio_to, timing.controllers)
        for controller in timing.controllers:
            yield from unknown(f"{where}: timing", "block", controller, BLOCKS)


def unknown(where: str, what: str, name: str, known: Iterable[str]) -> Iterator[Problem]:
    """The problem that a name is unknown, or nothing.

    Args:
        where: The place of the name, for the message.
        what: What the name stands for: scenario, block, ...
        name: The name in question.
        known: All valid names.
    """
    valid = list(known)
    if name not in valid:
        remedy = did_you_mean(name, valid) or "Nothing is left out silently: add it, or take it off the list."
        yield Problem(where, f"the unknown {what} `{name}`", choices(valid), remedy)
