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


class Role(StrEnum):
    """What a run stands for when claims are decided."""

    MP = "mp"
    TWO_LEVEL = "two_level"
    ALGORITHM = "algorithm"
    LOOSE = "loose"
    PLUS = "plus"
    SWEEP = "sweep"


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Run(_Strict):
    """One run: a scenario, what fills its sockets instead, and changed parameters."""

    name: str
    task: str
    scenario: str
    plant: str
    controller: str
    settings: tuple[str, ...] = ()
    role: Role
    label: str


class Sweep(_Strict):
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

    def runs(self) -> list[Run]:
        """One run per value."""
        return [
            Run(
                name=f"{self.name}-{value:g}",
                task=self.task,
                scenario=self.scenario,
                plant=self.plant,
                controller=self.controller,
                settings=(f"{self.parameter}={value!r}",),
                role=Role.SWEEP,
                label=f"{self.label}, {self.parameter.partition('.')[2]} = {value:g} {self.unit}",
            )
            for value in self.values
        ]


class TimingPlan(_Strict):
    """Which controllers are timed, on the states of which run, and what the ratios refer to."""

    states: str
    controllers: tuple[str, ...]
    ratio_to: str


class Kind(StrEnum):
    """What a figure shows."""

    TRAJECTORY = "trajectory"
    YAW_RATE = "yaw_rate"
    DISTANCE = "distance"
    SMOOTHNESS = "smoothness"


class Picture(_Strict):
    """A figure of the report."""

    name: str
    kind: Kind
    runs: tuple[str, ...]
    caption: str


class Experiments(_Strict):
    """All that `macrostep reproduce` runs."""

    runs: tuple[Run, ...]
    sweeps: tuple[Sweep, ...] = ()
    timing: TimingPlan | None = None
    figures: tuple[Picture, ...] = ()

    def all_runs(self) -> list[Run]:
        """The runs, and those that the sweeps are made of."""
        return [*self.runs, *(run for sweep in self.sweeps for run in sweep.runs())]


def load(path: Path = EXPERIMENTS) -> Experiments:
    """The list of experiments. Raises `RequestError` with everything that this installation does not have."""
    found = checked(Experiments, read_toml(path), path.name)
    raise_if_any(_problems(found, path.name))
    return found


def _problems(found: Experiments, where: str) -> Iterator[Problem]:
    names = [run.name for run in found.all_runs()]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield Problem(f"{where}: {name}", "two runs of this name", "one name for each run")
    for run in (*found.runs, *found.sweeps):
        yield from unknown(f"{where}: {run.name}", "scenario", run.scenario, scenario_file.names())
        yield from unknown(f"{where}: {run.name}", "block", run.plant, BLOCKS)
        yield from unknown(f"{where}: {run.name}", "block", run.controller, BLOCKS)
    for figure in found.figures:
        for name in figure.runs:
            yield from unknown(f"{where}: figure {figure.name}", "run", name, names)
    if found.timing is not None:
        yield from unknown(f"{where}: timing.states", "run", found.timing.states, names)
        yield from unknown(f"{where}: timing.ratio_to", "controller", found.timing.ratio_to, found.timing.controllers)
        for controller in found.timing.controllers:
            yield from unknown(f"{where}: timing", "block", controller, BLOCKS)


def unknown(where: str, kind: str, name: str, known: Iterable[str]) -> Iterator[Problem]:
    """The problem with a name that is not known, if it is not."""
    listed = list(known)
    if name not in listed:
        remedy = did_you_mean(name, listed) or "Nothing is left out silently: add it, or take it off the list."
        yield Problem(where, f"the unknown {kind} `{name}`", choices(listed), remedy)
