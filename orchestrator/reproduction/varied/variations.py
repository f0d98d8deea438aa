"""Variations of the scenarios: the values that are drawn for a case, and the settings that follow from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import BaseModel, ConfigDict

from components import BLOCKS
from components.interfaces.problem import Problem, raise_if_any, refuse
from orchestrator.reproduction.paper.experiments import RunRole, unknown
from orchestrator.scenario import scenario_file
from orchestrator.system.files import checked, read_toml

VARIATIONS: Final = Path(__file__).parent / "variations.toml"
TASKS: Final = ("static", "dynamic", "dynamic-slow")
"""The scenarios that are varied, in the order of the case numbers."""

NOMINAL_MASS: Final = 2000.0
"""[kg] The mass that controllers assume."""

_DIGITS: Final = 4
"""Drawn values are rounded to so many decimals, so that a person can type them."""

_EDGES: Final = ("y_left", "y_right")
"""Edges of the road, which not every controller has as parameters."""


class Range(BaseModel):
    """The interval that a value is drawn from, uniformly."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    low: float
    high: float
    unit: str
    what: str
    """The meaning of the value, for the report."""
    count: int = 1
    """How many values are drawn independently."""


class VariedController(BaseModel):
    """A controller that takes part in the cases of some tasks."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    controller: str
    settings: tuple[str, ...] = ()
    tasks: tuple[str, ...] = TASKS
    role: RunRole
    label: str
    curve: str = ""
    """The label of the curve of gains that it is a point of; empty where it is none."""


class VariedPlan(BaseModel):
    """The plant, the controllers and the ranges of the varied set."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    plant: str
    controllers: tuple[VariedController, ...]
    ranges: dict[str, dict[str, Range]]
    """By task (`common`: for all tasks) and name of the value."""


@dataclass(frozen=True)
class VariedCase:
    """One variation of a task."""

    number: int
    task: str
    drawn: Mapping[str, float | list[float]]
    """The drawn values, by their names in the ranges."""

    @property
    def stop_time(self) -> float:
        """[s] The time until the last obstacle is passed; without one, until the vehicle is where the scenario ends."""
        d: Mapping[str, Any] = self.drawn
        if self.task == "dynamic":
            distance, closing = 113.0, d["v"]
        else:
            closing = d["v"] * (1 - d.get("slower", 0.0))
            distance = d["x_first"] + d["ahead"] + d["apart"] + 5.0
        return round(float(np.ceil(distance / closing * 10)) / 10, 1)

    @property
    def values(self) -> dict[str, dict[str, Any]]:
        """The values of the parameters, by unit and name."""
        d: Mapping[str, Any] = self.drawn
        v, w = d["v"], d["w"]
        road = {"y_adjacent": w, "y_left": _rounded(1.5 * w), "y_right": _rounded(-w / 2)}
        return {
            "plant": {"v_x_start": v, "mu": d["mu"], "m": _rounded(NOMINAL_MASS * d["mass"])},
            "controller": {"v_ref": v, "mu": d["mu"], "l_d": d["l_d"], **road, **self._task()},
            "scene": road,
            "traffic": self._traffic(),
        }

    def settings(self) -> list[str]:
        """The values as `macrostep run --set` takes them."""
        return _settings(self.values)

    def _task(self) -> dict[str, float]:
        return {"x_task": float(self.drawn["x_task"])} if self.task == "dynamic" else {}  # type: ignore[arg-type]

    def _traffic(self) -> dict[str, list[float]]:
        d: Mapping[str, Any] = self.drawn
        v, w, aside = d["v"], d["w"], d["aside"]
        if self.task == "dynamic":
            lanes, speeds = (0.0, w, 0.0), [v] * 3
            x = [start + shift for start, shift in zip((15.0, -30.0, -40.0), d["shift"], strict=True)]
            final = {"v_final": [v * share for share in d["faster"]], "a": list(d["a"])}
        else:
            lanes, speeds = (0.0, w, w), [v * d.get("slower", 0.0)] * 3
            x = [d["x_first"], d["x_first"] + d["ahead"], d["x_first"] + d["ahead"] + d["apart"]]
            final = {"v_final": speeds}
        y = [lane + offset for lane, offset in zip(lanes, aside, strict=True)]
        traffic = {"x_start": x, "y_start": y, "v_start": speeds, **final}
        return {name: [_rounded(value) for value in values] for name, values in traffic.items()}


@dataclass(frozen=True)
class VariedRequest:
    """The cases that are to be run."""

    plan: VariedPlan
    seed: int
    cases: tuple[VariedCase, ...]


def request(count: int, seed: int) -> VariedRequest:
    """The first cases of a seed.

    Args:
        count: The number of cases.
        seed: The seed of the random numbers.

    Raises:
        RequestError: `count` is not positive, or `seed` is negative.
    """
    if count < 1:
        raise refuse("--varied", f"{count}", "a whole number of cases, 1 or more")
    if seed < 0:
        raise refuse("--seed", f"{seed}", "a whole number, 0 or more")
    plan = load()
    return VariedRequest(plan, seed, tuple(draw(plan.ranges, seed, number) for number in range(count)))


def load(path: Path = VARIATIONS) -> VariedPlan:
    """Read the plan of the varied set.

    Raises:
        RequestError: Names in the plan are unknown; the error has all of them.
    """
    plan = checked(VariedPlan, read_toml(path), path.name)
    raise_if_any(_problems(plan, path.name))
    return plan


def _problems(plan: VariedPlan, where: str) -> Iterator[Problem]:
    yield from unknown(f"{where}: plant", "block", plan.plant, BLOCKS)
    for controller in plan.controllers:
        yield from unknown(f"{where}: {controller.name}", "block", controller.controller, BLOCKS)
        for task in controller.tasks:
            yield from unknown(f"{where}: {controller.name}", "task", task, TASKS)
    for task in TASKS:
        yield from unknown(f"{where}: ranges", "table", task, plan.ranges)
        yield from unknown(where, "scenario", task, scenario_file.names())


def draw(ranges: Mapping[str, Mapping[str, Range]], seed: int, number: int) -> VariedCase:
    """Draw the case `number` of a seed; `ranges` as in `VariedPlan`."""
    generator = np.random.default_rng([seed, number])
    task = TASKS[number % len(TASKS)]
    drawn: dict[str, float | list[float]] = {}
    for name, r in {**ranges["common"], **ranges[task]}.items():
        values = [_rounded(value) for value in generator.uniform(r.low, r.high, r.count)]
        drawn[name] = values if r.count > 1 else values[0]
    return VariedCase(number, task, drawn)


def settings_for(case: VariedCase, controller: VariedController) -> list[str]:
    """All settings of a case for one controller; edges of the road only where it has them as parameters."""
    declared = {v.name for v in BLOCKS[controller.controller].parameters()}
    values = case.values
    for name in _EDGES:
        if name not in declared:
            del values["controller"][name]
    return [*controller.settings, *_settings(values)]


def command(case: VariedCase, controller: VariedController, plant: str) -> str:
    """The command that runs one case again."""
    settings = " ".join(f"--set '{setting}'" for setting in settings_for(case, controller))
    return (
        f"macrostep run {case.task} --plant {plant} --controller {controller.controller} "
        f"--stop-time {case.stop_time:g} {settings}"
    )


def _settings(values: Mapping[str, Mapping[str, Any]]) -> list[str]:
    return [f"{unit}.{name}={value!r}" for unit, parameters in values.items() for name, value in parameters.items()]


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS)
