"""Wall time per sample of the controllers, all measured in one go on the same recorded states.

Nothing else runs here meanwhile. The samples follow each other as in the run that they are taken from, so that each
controller starts from its own previous plan, and one pass over all of them follows the other, controller by controller.
A first pass is not counted.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
import pandas as pd

from components import BLOCKS
from components.interfaces.quantity import DTYPES, Type
from components.interfaces.record import Variable
from fmus.units.unit import Column, Unit, positions, widths
from orchestrator.reproduction.paper.evidence import AS_FMU, IN_PROCESS, Timing
from orchestrator.reproduction.paper.experiments import TimingPlan
from orchestrator.reproduction.runs import MODE, Outcome, options
from orchestrator.scenario.options import Mode, Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.source import UnitSource

PASSES: Final = 3
"""How often all states are sampled, after the pass that is not counted."""

STEP: Final = 0.1
"""[s] from sample to sample."""

_DRIVERS: Final = {"ego": "plant.state", "obstacles": "traffic.obstacles"}
"""Where the inputs of a controller were recorded."""


def measure(plan: TimingPlan, outcomes: Mapping[str, Outcome], progress: Callable[[str], None]) -> list[Timing]:
    """Median and 99th percentile of each controller's time per sample; native ones as FMU too."""
    states = outcomes[plan.states]
    frame = pd.read_parquet(states.folder / "signals.parquet")
    sources: dict[tuple[str, str], UnitSource] = {}
    for name in plan.controllers:
        sources[name, IN_PROCESS] = _controller(states, name, "blocks")
        if BLOCKS[name].native:
            sources[name, AS_FMU] = _controller(states, name, MODE)
    times: dict[tuple[str, str], list[float]] = {key: [] for key in sources}
    for number in range(PASSES + 1):
        for (name, way), source in sources.items():
            progress(f"timing {name}, {way}, pass {number} of {PASSES}")
            times[name, way] += _pass(source, frame) if number else _pass(source, frame)[:0]
    reference = times[plan.ratio_to, IN_PROCESS]
    return [_timing(name, way, found, reference) for (name, way), found in times.items()]


def _timing(name: str, way: str, found: Sequence[float], reference: Sequence[float]) -> Timing:
    (p50, p99), (r50, r99) = (np.percentile(values, [50, 99]) for values in (found, reference))
    return Timing(name, way, float(p50 * 1e6), float(p99 * 1e6), float(p50 / r50), float(p99 / r99))


def _controller(states: Outcome, name: str, mode: Mode) -> UnitSource:
    """A controller with the parameters it would have in the run that the states are taken from."""
    replacements = {**options(states.run).replacements, "controller": name}
    made = prepare(states.run.scenario, Options(mode=mode, replacements=replacements))
    return made.system.units["controller"]


def _pass(source: UnitSource, frame: pd.DataFrame) -> list[float]:
    """Seconds of every sample of a run, from a fresh start."""
    unit = source.open("controller")
    try:
        inputs, outputs = (
            {kind: np.zeros(n, DTYPES[kind]) for kind, n in widths(variables).items()}
            for variables in (unit.interface.inputs, unit.interface.outputs)
        )
        unit.bind(inputs, outputs)
        rows = _rows(unit.interface.inputs, frame)
        unit.enter_initialization(source.parameters)
        _put(inputs, rows, 0)
        _all(unit.setters())
        unit.exit_initialization()
        return _samples(unit, inputs, rows)
    finally:
        unit.close()


def _samples(unit: Unit, inputs: Mapping[Type, Column], rows: Mapping[Type, Column]) -> list[float]:
    found: list[float] = []
    setters, getters = unit.setters(), unit.getters()
    for k in range(len(rows[Type.FLOAT64])):
        _put(inputs, rows, k)
        began = time.perf_counter()
        _all(setters)
        unit.step(k * STEP, STEP)
        _all(getters)
        found.append(time.perf_counter() - began)
    return found


def _put(inputs: Mapping[Type, Column], rows: Mapping[Type, Column], k: int) -> None:
    for kind, column in inputs.items():
        column[:] = rows[kind][k]


def _all(calls: Sequence[Callable[[], object]]) -> None:
    for call in calls:
        call()


def _rows(variables: Sequence[Variable], frame: pd.DataFrame) -> dict[Type, Column]:
    """The recorded inputs, (rows, elements) by type, in the order of the unit's columns."""
    found = {kind: np.zeros((len(frame), n), DTYPES[kind]) for kind, n in widths(variables).items()}
    places = positions(variables)
    for variable in variables:
        bus, _, rest = variable.name.partition(".")
        kind, at = places[variable.name]
        for i, element in enumerate(variable.elements):
            column = f"{_DRIVERS[bus]}.{rest}{element[len(variable.name) :]}"
            found[kind][:, at + i] = frame[column].to_numpy()
    return found
