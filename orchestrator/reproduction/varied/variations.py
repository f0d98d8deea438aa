"""Variations of the scenarios: what is drawn, and the settings that a case comes to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from pydantic import BaseModel, ConfigDict

from components import BLOCKS
from components.interfaces.problem import Problem, raise_if_any, refuse
from orchestrator.reproduction.paper.experiments import Role, unknown
from orchestrator.scenario import scenario_file
from orchestrator.system.files import checked, read_toml

VARIATIONS: Final = Path(__file__).parent / "variations.toml"
TASKS: Final = ("static", "dynamic", "dynamic-slow")
"""The scenarios that are varied, in the order of the case numbers."""

MASS: Final = 2000.0
"""[kg] nominal mass, which controllers count on"""

_DIGITS: Final = 4
"""Drawn values are rounded, so that a person can type them."""

_EDGES: Final = ("y_left", "y_right")
"""Parameters of the scene that not every controller has."""


class Range(BaseModel):
    """Between which values something is drawn, evenly."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    low: float
    high: float
    unit: str
    what: str
    count: int = 1


class Driver(BaseModel):
    """A controller that drives all cases of some tasks."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    controller: str
    settings: tuple[str, ...] = ()
    tasks: tuple[str, ...] = TASKS
    role: Role
    label: str
    curve: str = ""
    """The curve of gains that it is a point of"""


class Variations(BaseModel):
    """The ranges, and who drives."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    plant: str
    controllers: tuple[Driver, ...]
    ranges: dict[str, dict[str, Range]]


@dataclass(frozen=True)
class Case:
    """One variation: what was drawn."""

    number: int
    task: str
    drawn: Mapping[str, float | list[float]]

    @property
    def stop_time(self) -> float:
        """[s] until the last obstacle is passed; as far as in the scenario where none is."""
        d: Mapping[str, Any] = self.drawn
        if self.task == "dynamic":
            distance, closing = 113.0, d["v"]
        else:
            closing = d["v"] * (1 - d.get("slower", 0.0))
            distance = d["x_first"] + d["ahead"] + d["apart"] + 5.0
        return round(float(np.ceil(distance / closing * 10)) / 10, 1)

    def settings(self) -> list[str]:
        """What `macrostep run --set` is told, whoever drives."""
        d: Mapping[str, Any] = self.drawn
        v, w = d["v"], d["w"]
        road = {"y_adjacent": w, "y_left": _rounded(1.5 * w), "y_right": _rounded(-w / 2)}
        found = {
            "plant": {"v_x_start": v, "mu": d["mu"], "m": _rounded(MASS * d["mass"])},
            "controller": {"v_ref": v, "mu": d["mu"], "l_d": d["l_d"], **road, **self._task()},
            "scene": road,
            "traffic": self._traffic(),
        }
        return [f"{unit}.{name}={value!r}" for unit, values in found.items() for name, value in values.items()]

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
        found = {"x_start": x, "y_start": y, "v_start": speeds, **final}
        return {name: [_rounded(value) for value in values] for name, values in found.items()}


@dataclass(frozen=True)
class Request:
    """Which cases are to be driven."""

    variations: Variations
    seed: int
    cases: tuple[Case, ...]


def request(count: int, seed: int) -> Request:
    """The first `count` cases of a seed. Raises `RequestError`."""
    if count < 1:
        raise refuse("--varied", f"{count}", "a whole number of cases, 1 or more")
    if seed < 0:
        raise refuse("--seed", f"{seed}", "a whole number, 0 or more")
    found = load()
    return Request(found, seed, tuple(draw(found.ranges, seed, number) for number in range(count)))


def load(path: Path = VARIATIONS) -> Variations:
    """The ranges and drivers. Raises `RequestError` with everything that this installation does not have."""
    found = checked(Variations, read_toml(path), path.name)
    raise_if_any(_problems(found, path.name))
    return found


def _problems(found: Variations, where: str) -> Iterator[Problem]:
    yield from unknown(f"{where}: plant", "block", found.plant, BLOCKS)
    for driver in found.controllers:
        yield from unknown(f"{where}: {driver.name}", "block", driver.controller, BLOCKS)
        for task in driver.tasks:
            yield from unknown(f"{where}: {driver.name}", "task", task, TASKS)
    for task in TASKS:
        yield from unknown(f"{where}: ranges", "table", task, found.ranges)
        yield from unknown(where, "scenario", task, scenario_file.names())


def draw(ranges: Mapping[str, Mapping[str, Range]], seed: int, number: int) -> Case:
    """Case `number` of a seed."""
    generator = np.random.default_rng([seed, number])
    task = TASKS[number % len(TASKS)]
    drawn: dict[str, float | list[float]] = {}
    for name, r in {**ranges["common"], **ranges[task]}.items():
        values = [_rounded(value) for value in generator.uniform(r.low, r.high, r.count)]
        drawn[name] = values if r.count > 1 else values[0]
    return Case(number, task, drawn)


def settings_for(case: Case, driver: Driver) -> list[str]:
    """All settings of a case for one controller; edges of the road only where it knows of them."""
    known = {v.name for v in BLOCKS[driver.controller].parameters()}
    absent = tuple(f"controller.{name}=" for name in _EDGES if name not in known)
    return [*driver.settings, *(text for text in case.settings() if not text.startswith(absent or "\0"))]


def command(case: Case, driver: Driver, plant: str) -> str:
    """The command that runs one case again."""
    settings = " ".join(f"--set '{text}'" for text in settings_for(case, driver))
    return (
        f"macrostep run {case.task} --plant {plant} --controller {driver.controller} "
        f"--stop-time {case.stop_time:g} {settings}"
    )


def _rounded(value: float) -> float:
    return round(float(value), _DIGITS)
