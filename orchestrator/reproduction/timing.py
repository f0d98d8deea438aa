"""Wall time per sample of the controllers, all measured in one go on the same recorded states.

Nothing else runs in this process meanwhile. The samples follow each other as in the run that they are taken from, so
that each controller starts from its own previous plan. One pass over all samples follows the other, controller by
controller; the first pass warms up and does not count.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
import pandas as pd

from components import BLOCKS
from components.interfaces.progress import Progress
from components.interfaces.quantity import DTYPES, Type
from components.interfaces.sockets import CONTROLLER
from fmus.units.unit import Column, Unit, positions, widths
from orchestrator.reproduction.paper.evidence import AS_FMU, IN_PROCESS, Timing
from orchestrator.reproduction.paper.experiments import TimingPlan
from orchestrator.reproduction.runs import MODE, Outcome, options
from orchestrator.scenario.options import Mode, Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.experiment import Scenario
from orchestrator.system.system import System

TIMED_PASSES: Final = 3
"""How often all states are sampled, after the pass that does not count."""


def measure(plan: TimingPlan, outcomes: Mapping[str, Outcome], progress: Progress) -> list[Timing]:
    """Measure the controllers of a plan; a native one in this process and as an FMU.

    Args:
        plan: The controllers, and the run whose states they are given.
        outcomes: The executed runs by name.
        progress: Receives a report on each pass over the samples.

    Returns:
        Median and 99th percentile of the time per sample of each controller, in each way that it runs.
    """
    states = outcomes[plan.states]
    frame = states.rows()
    scenarios: dict[tuple[str, str], Scenario] = {}
    for name in plan.controllers:
        scenarios[name, IN_PROCESS] = _scenario(states, name, "blocks")
        if BLOCKS[name].native:
            scenarios[name, AS_FMU] = _scenario(states, name, MODE)
    times: dict[tuple[str, str], list[float]] = {key: [] for key in scenarios}
    for number in range(TIMED_PASSES + 1):
        for (name, way), scenario in scenarios.items():
            progress.now(f"timing {name}, {way}, pass {number} of {TIMED_PASSES}")
            samples = _pass(scenario, frame)
            times[name, way] += samples if number else []
    reference = times[plan.ratio_to, IN_PROCESS]
    return [_timing(name, way, seconds, reference) for (name, way), seconds in times.items()]


def _timing(name: str, way: str, seconds: Sequence[float], reference: Sequence[float]) -> Timing:
    (p50, p99), (r50, r99) = (np.percentile(values, [50, 99]) for values in (seconds, reference))
    return Timing(name, way, float(p50 * 1e6), float(p99 * 1e6), float(p50 / r50), float(p99 / r99))


def _scenario(states: Outcome, name: str, mode: Mode) -> Scenario:
    """The run that the states are taken from, with another controller and its own parameters."""
    replacements = {**options(states.run).replacements, CONTROLLER.name: name}
    return prepare(states.run.scenario, Options(mode=mode, replacements=replacements))


def _pass(scenario: Scenario, frame: pd.DataFrame) -> list[float]:
    """Seconds that the controller takes for every sample of a run, from a fresh start."""
    source = scenario.system.units[CONTROLLER.name]
    unit = source.open(CONTROLLER.name)
    try:
        inputs, outputs = (
            {kind: np.zeros(n, DTYPES[kind]) for kind, n in widths(variables).items()}
            for variables in (unit.interface.inputs, unit.interface.outputs)
        )
        unit.bind(inputs, outputs)
        rows = _recorded_inputs(scenario.system, frame)
        unit.enter_initialization(source.parameters)
        _put(inputs, rows, 0)
        _all(unit.setters())
        unit.exit_initialization()
        return _samples(unit, inputs, rows, scenario.h)
    finally:
        unit.close()


def _samples(unit: Unit, inputs: Mapping[Type, Column], rows: Mapping[Type, Column], h: float) -> list[float]:
    seconds: list[float] = []
    setters, getters = unit.setters(), unit.getters()
    for k in range(len(rows[Type.FLOAT64])):
        _put(inputs, rows, k)
        began = time.perf_counter()
        _all(setters)
        unit.step(k * h, h)
        _all(getters)
        seconds.append(time.perf_counter() - began)
    return seconds


def _put(inputs: Mapping[Type, Column], rows: Mapping[Type, Column], k: int) -> None:
    for kind, column in inputs.items():
        column[:] = rows[kind][k]


def _all(calls: Sequence[Callable[[], object]]) -> None:
    for call in calls:
        call()


def _recorded_inputs(system: System, frame: pd.DataFrame) -> dict[Type, Column]:
    """What drove the inputs of the controller: `(rows, elements)` by type, in the order of the unit's columns."""
    inputs = system.units[CONTROLLER.name].interface.inputs
    rows = {kind: np.zeros((len(frame), n), DTYPES[kind]) for kind, n in widths(inputs).items()}
    places = positions(inputs)
    for connection in system.connections:
        if connection.unit == CONTROLLER.name:
            kind, at = places[connection.input]
            driver = system.variable(f"{connection.source}.{connection.output}")
            columns = [f"{connection.source}.{element}" for element in driver.elements]
            rows[kind][:, at : at + len(columns)] = frame[columns].to_numpy()
    return rows
