"""The varied set: every case is run with every controller, on all cores, without recordings.

Each process opens the FMUs once and changes their parameters only. A case that is run again by its command gives the
same numbers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import pandas as pd

from components.interfaces.problem import refuse
from components.interfaces.progress import Progress
from orchestrator.reproduction import runs
from orchestrator.reproduction.paper.evidence import RecordedRun, Result, more_metrics
from orchestrator.reproduction.varied import variations
from orchestrator.reproduction.varied.variations import VariedCase, VariedController, VariedPlan, VariedRequest
from orchestrator.results import metrics
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import SimulationError
from orchestrator.sweeping.engine import workforce
from orchestrator.sweeping.kept_scenario import KeptScenario
from orchestrator.system.experiment import Scenario, TimeGrid
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
    with workforce(None, None).executor() as pool:
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
    last = TimeGrid(_prepared(case.task, controller.controller, plant).h, case.stop_time).last_tick
    kept = _kept(case.task, controller.controller, plant, last // _ROOM + 1)
    values, scene = _changes(kept, variations.settings_for(case, controller))
    fault = ""
    with kept.pool.simulation(values) as simulation:
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
def _kept(task: str, controller: str, plant: str, rooms: int) -> KeptScenario:
    """A scenario that this process keeps open, long enough for `rooms` times `_ROOM` ticks."""
    scenario = _prepared(task, controller, plant)
    return KeptScenario(dataclasses.replace(scenario, until=scenario.h * (rooms * _ROOM)))


def _changes(kept: KeptScenario, texts: list[str]) -> tuple[dict[str, Any], Scene]:
    """The values and the scene of a case. Raises `RequestError` where a setting does not fit, or there is no scene."""
    changes = kept.changes(texts)
    if changes is None or changes[1] is None:
        raise refuse(kept.scenario.name, "a scenario that settings cannot change", "one with a scene and parameters")
    return changes[0], changes[1]
