"""The varied set: every case is run with every controller, on all cores, without recordings.

Each process opens the FMUs once and changes their parameters only. A case that is run again by its command gives the
same numbers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import pandas as pd

from components.interfaces.problem import raise_if_any, refuse
from components.interfaces.progress import Progress
from components.interfaces.record import Variable, variables
from orchestrator.reproduction import runs
from orchestrator.reproduction.paper.evidence import RecordedRun, Result, more_metrics
from orchestrator.reproduction.varied import variations
from orchestrator.reproduction.varied.variations import VariedCase, VariedController, VariedPlan, VariedRequest
from orchestrator.results import metrics
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.scenario.resolution import resolve
from orchestrator.scenario.settings import parse_settings
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.simulation_pool import SimulationPool
from orchestrator.system.experiment import Scenario, TimeGrid
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene
from orchestrator.system.shown import shown

_ROOM: Final = 1000
"""[ticks] Simulations that are kept are as long as a multiple of this, so that they serve cases of any length."""


@dataclass(frozen=True)
class CaseResults:
    """The results of a case with each controller."""

    case: VariedCase
    results: Mapping[str, Result]
    """The results by the controller's name in the plan."""
    faults: Mapping[str, str]
    """What ended a run before its time, by the controller's name in the plan."""


@dataclass(frozen=True)
class VariedSet:
    """The results of all cases that were asked for."""

    plan: VariedPlan
    seed: int
    cases: tuple[CaseResults, ...]


def build(request: VariedRequest, progress: Progress) -> None:
    """Build the FMUs that the cases need."""
    blocks = {request.plan.plant, *(controller.controller for controller in request.plan.controllers)}
    runs.build_blocks(blocks, set(variations.TASKS), progress)


def run(request: VariedRequest, done: Callable[[], None]) -> VariedSet:
    """Run all cases on all cores; `done` is called after each."""
    results: dict[int, CaseResults] = {}
    with runs.processes() as pool:
        futures = [pool.submit(run_case, case, request.plan) for case in request.cases]
        for future in as_completed(futures):
            results[future.result().case.number] = future.result()
            done()
    return VariedSet(request.plan, request.seed, tuple(results[case.number] for case in request.cases))


def run_case(case: VariedCase, plan: VariedPlan) -> CaseResults:
    """Run one case with every controller that takes part in its task."""
    results: dict[str, Result] = {}
    faults: dict[str, str] = {}
    for controller in plan.controllers:
        if case.task not in controller.tasks:
            continue
        frame, scene, fault = simulate(case, controller, plan.plant)
        buses = shown(_prepared(case.task, controller.controller, plan.plant).system)
        measured: dict[str, float] = {}
        if len(frame):
            measured = {**metrics.compute(frame, buses, scene), **more_metrics(RecordedRun(frame, buses))}
        results[controller.name] = Result(
            name=controller.name,
            task=case.task,
            plant=plan.plant,
            controller=controller.controller,
            role=controller.role,
            label=controller.label,
            metrics=measured,
            finished=not fault,
        )
        faults |= {controller.name: fault} if fault else {}
    return CaseResults(case, results, faults)


def simulate(case: VariedCase, controller: VariedController, plant: str) -> tuple[pd.DataFrame, Scene, str]:
    """Simulate one case with one controller.

    Args:
        case: The case.
        controller: The controller, which replaces that of the scenario.
        plant: The name of the plant's block.

    Returns:
        All rows, the scene, and the fault that ended the simulation, or an empty text.
    """
    scenario = _prepared(case.task, controller.controller, plant)
    values, scene = _with_settings(scenario, variations.settings_for(case, controller))
    last = TimeGrid(scenario.h, case.stop_time).last_tick
    fault = ""
    with _pool(case.task, controller.controller, plant, last // _ROOM + 1).simulation(values) as simulation:
        try:
            while simulation.tick < last and not simulation.is_over:
                simulation.step()
        except SimulationError as error:
            fault = str(error)
        return simulation.frame(), scene, fault


@cache
def _prepared(task: str, controller: str, plant: str) -> Scenario:
    """A scenario before a case changes it; its FMUs are opened once in each process."""
    return prepare(task, Options(mode=runs.MODE, replacements={"plant": plant, "controller": controller}))


@cache
def _pool(task: str, controller: str, plant: str, rooms: int) -> SimulationPool:
    """The simulations of a scenario that this process keeps open, long enough for `rooms` times `_ROOM` ticks."""
    scenario = _prepared(task, controller, plant)
    return SimulationPool(lambda: Simulation(scenario.system, h=scenario.h, until=scenario.h * (rooms * _ROOM)))


def _with_settings(scenario: Scenario, texts: list[str]) -> tuple[dict[str, Any], Scene]:
    """The values of all parameters of a prepared scenario that is changed as by `--set`.

    Args:
        scenario: The scenario.
        texts: The changes, written as for `--set`.

    Returns:
        The values by full path, and the changed scene.

    Raises:
        RequestError: A setting does not fit, or the scenario has no scene.
    """
    if scenario.scene is None:
        raise refuse(scenario.name, "no scene", "a scenario with a scene")
    settings = parse_settings(texts)
    values: dict[str, Any] = {}
    for name, source in scenario.system.units.items():
        declared = source.interface.parameters
        resolution = resolve(name, declared, _given(scenario, name, declared), settings=settings[name])
        raise_if_any(resolution.problems)
        values |= {f"{name}.{parameter}": value for parameter, value in resolution.values.items()}  # noqa: PD011
    scene = resolve("scene", variables(Scene), settings=settings["scene"])
    raise_if_any(scene.problems)
    return values, dataclasses.replace(scenario.scene, **scene.values)


def _given(scenario: Scenario, unit: str, declared: Sequence[Variable]) -> dict[str, Given]:
    paths = {variable.name: f"{unit}.{variable.name}" for variable in declared}
    return {name: Given(**scenario.sources[path]) for name, path in paths.items() if path in scenario.sources}
