"""The varied set: every controller drives every case, on all cores, without recordings.

Each process opens the FMUs once and changes parameters only (see `kept`); a case that is run again by its command
gives the same numbers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import cache
from typing import Final

import pandas as pd

from components.interfaces.problem import raise_if_any, refuse
from components.interfaces.sockets import SOCKETS
from orchestrator.reproduction import runs
from orchestrator.reproduction.paper.evidence import Result, more_metrics
from orchestrator.reproduction.varied import variations
from orchestrator.reproduction.varied.variations import Case, Driver, Request, Variations
from orchestrator.results import metrics
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.scenario.resolution import resolve
from orchestrator.scenario.scenario_file import read
from orchestrator.scenario.settings import parse_settings
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.experiment import Scenario
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System

_ROLES: Final = {name: name for name in SOCKETS}


@dataclass(frozen=True)
class Driven:
    """A case, and what became of it with each controller."""

    case: Case
    results: Mapping[str, Result]
    """By the driver's name"""
    faults: Mapping[str, str]


@dataclass(frozen=True)
class VariedSet:
    """All cases of a seed."""

    variations: Variations
    seed: int
    driven: tuple[Driven, ...]


def build(request: Request, progress: Callable[[str], None]) -> None:
    """Build the FMUs that the cases need."""
    traffic = {read(task)[1].units["traffic"].block for task in variations.TASKS}
    blocks = {request.variations.plant, *(driver.controller for driver in request.variations.controllers)}
    runs.build_blocks(blocks | {name for name in traffic if name}, progress)


def run(request: Request, done: Callable[[], None]) -> VariedSet:
    """Drive all cases on all cores; `done` is called after each."""
    driven: dict[int, Driven] = {}
    with runs.processes() as pool:
        futures = [pool.submit(drive, case, request.variations) for case in request.cases]
        for future in as_completed(futures):
            driven[future.result().case.number] = future.result()
            done()
    return VariedSet(request.variations, request.seed, tuple(driven[case.number] for case in request.cases))


def drive(case: Case, found: Variations) -> Driven:
    """One case with every controller."""
    results: dict[str, Result] = {}
    faults: dict[str, str] = {}
    for driver in found.controllers:
        if case.task not in driver.tasks:
            continue
        frame, scene, fault = simulate(case, driver, found.plant)
        told = {**metrics.compute(frame, _ROLES, scene), **more_metrics(frame)} if len(frame) else {}
        results[driver.name] = Result(
            name=driver.name,
            task=case.task,
            plant=found.plant,
            controller=driver.controller,
            role=driver.role,
            label=driver.label,
            metrics=told,
            finished=not fault,
        )
        faults |= {driver.name: fault} if fault else {}
    return Driven(case, results, faults)


def simulate(case: Case, driver: Driver, plant: str) -> tuple[pd.DataFrame, Scene, str]:
    """All rows of one case with one controller, its scene, and the fault that ended it, if any."""
    made = _prepared(case.task, driver.controller, plant)
    texts = variations.settings_for(case, driver)
    system, scene = with_settings(made, texts)
    simulation = Simulation(system, h=made.h, until=case.stop_time)
    try:
        with simulation:
            simulation.run()
    except SimulationError as error:
        return simulation.frame(), scene, str(error)
    return simulation.frame(), scene, ""


@cache
def _prepared(task: str, controller: str, plant: str) -> Scenario:
    """A scenario as it is before a case changes it; its FMUs are opened once in each process."""
    return prepare(task, Options(mode=runs.MODE, replacements={"plant": plant, "controller": controller}))


def with_settings(made: Scenario, texts: list[str]) -> tuple[System, Scene]:
    """The system and scene of a prepared scenario with other settings: what `--set` does. Raises `RequestError`."""
    if made.scene is None:
        raise refuse(made.name, "no scene", "a scenario with a scene")
    settings = parse_settings(texts)
    units: dict[str, UnitSource] = {}
    for name, source in made.system.units.items():
        found = resolve(name, source.interface.parameters, _given(made, name), settings=settings[name])
        raise_if_any(found.problems)
        units[name] = source.with_parameters(found.values).kept()
    scene = {s.name: s.value for s in settings["scene"]}
    return dataclasses.replace(made.system, units=units), dataclasses.replace(made.scene, **scene)


def _given(made: Scenario, unit: str) -> dict[str, Given]:
    prefix = f"{unit}."
    return {n.removeprefix(prefix): Given(**told) for n, told in made.sources.items() if n.startswith(prefix)}
