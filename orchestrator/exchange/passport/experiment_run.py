"""An experiment with stimuli and reference results, driven in a measuring process and compared."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import DTYPES, Type
from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.units.unit import EndRequested, ExperimentSetup, views
from orchestrator.exchange.passport.excitation import own_step
from orchestrator.exchange.passport.running import Running
from orchestrator.exchange.passport.workplace import Workplace

_LIMIT: Final = 1e-3
"""The relative deviation that is allowed where the experiment names no tolerance, and at least."""
_SAME_TIME: Final = 1e-9
"""[s] The difference of two instants that are the same."""
_MOST_STEPS: Final = 1_000_000


class TimeSeries(NamedTuple):
    """Values over time."""

    times: tuple[float, ...]
    columns: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class Experiment:
    """One smoke test; what it leaves open is what the FMU's default experiment says."""

    name: str
    start: float | None
    stop: float | None
    step: float | None
    tolerance: float | None
    parameters: Mapping[str, str]
    stimuli: TimeSeries | None
    references: TimeSeries

    @property
    def limit(self) -> float:
        """The deviation that is allowed, relative to the largest value of a signal."""
        return max(self.tolerance or 0.0, _LIMIT)


class WorstDeviation(NamedTuple):
    """The largest deviation from reference results."""

    name: str
    time: float
    relative: float
    compared: int
    """The number of signals that were compared."""


def drive_experiment(place: Workplace, experiment: Experiment) -> TimeSeries:
    """The outputs of an experiment at its communication points."""
    archive = place.archive
    place.tell(f"driving {experiment.name}")
    h = experiment.step or own_step(archive)
    start = archive.suggested.start if experiment.start is None else experiment.start
    stop = experiment.references.times[-1] if experiment.stop is None else experiment.stop
    parameters = {v.name: _typed(v, text) for v, text in _given(archive, experiment)}
    running = Running(archive, h, parameters, setup=ExperimentSetup(start, stop, experiment.tolerance))
    inputs = views(archive.interface.inputs, running.inputs)
    times: list[float] = []
    rows: list[NDArray[Any]] = []
    _stimulate(archive, inputs, experiment, start)
    with running:
        for k in range(min(round((stop - start) / h), _MOST_STEPS) + 1):
            times.append(start + k * h)
            rows.append(_numbers(running))
            _stimulate(archive, inputs, experiment, running.time)
            if running.time >= stop - 1e-9 * h:
                break
            try:
                running.step()
            except EndRequested:
                break
    names = [e for v in archive.interface.outputs if v.quantity.type.is_number for e in _names(archive, v)]
    columns = np.array(rows).T
    return TimeSeries(tuple(times), {name: tuple(columns[i].tolist()) for i, name in enumerate(names)})


def _numbers(running: Running) -> NDArray[Any]:
    shown = views(running.interface.outputs, running.outputs)
    parts = [shown[v.name].astype(float) for v in running.interface.outputs if v.quantity.type.is_number]
    return np.concatenate(parts) if parts else np.zeros(0)


def _names(archive: Archive, variable: Variable) -> list[str]:
    """The names of the elements of a variable, as the file spells them."""
    scalars = len(archive.references[variable.name]) == variable.size
    if variable.quantity.shape and scalars and variable.size > 1:
        return list(archive.element_names(variable.name, ("input", "output")))
    return variable.elements


def _given(archive: Archive, experiment: Experiment) -> list[tuple[Variable, str]]:
    known = (*archive.interface.parameters, *archive.interface.initials)
    return [(v, experiment.parameters[v.name]) for v in known if v.name in experiment.parameters]


def _typed(variable: Variable, text: str) -> Any:
    kind = variable.quantity.type
    if not kind.is_number:
        return text
    if kind is Type.BOOLEAN:
        return text.lower() in ("true", "1")
    values = [DTYPES[kind](float(part)) for part in text.split()]
    return np.resize(np.array(values), variable.shape) if variable.shape else values[0]


def _stimulate(archive: Archive, inputs: Mapping[str, NDArray[Any]], experiment: Experiment, t: float) -> None:
    """Put the values of the stimuli at an instant: linear for floating-point inputs, held for the others."""
    if experiment.stimuli is None:
        return
    times = np.asarray(experiment.stimuli.times)
    for variable in archive.interface.inputs:
        for i, name in enumerate(_names(archive, variable)):
            if name in experiment.stimuli.columns:
                values = np.asarray(experiment.stimuli.columns[name])
                if variable.quantity.type.is_float:
                    inputs[variable.name][i] = np.interp(t, times, values)
                elif variable.quantity.type.is_number:
                    row = max(0, int(np.searchsorted(times, t + 1e-12, side="right")) - 1)
                    inputs[variable.name][i] = values[row]


def worst_deviation(experiment: Experiment, rows: TimeSeries) -> WorstDeviation | None:
    """The largest deviation of the outputs from the references; None where there is nothing to compare.

    The instants of the references that are communication points count; where none is, the rows are interpolated.
    """
    reference = experiment.references
    compared = [name for name in reference.columns if name in rows.columns]
    if not compared:
        return None
    times, points = np.asarray(reference.times), np.asarray(rows.times)
    if times[-1] > points[-1] + _SAME_TIME:
        return WorstDeviation("the end", rows.times[-1], math.inf, len(compared))
    met = np.abs(times[:, None] - points[None, :]).min(axis=1) <= _SAME_TIME
    chosen = met if met.any() else np.ones_like(met)
    found: list[WorstDeviation] = []
    for name in compared:
        expected = np.asarray(reference.columns[name])
        values = np.interp(times, points, rows.columns[name])
        with np.errstate(invalid="ignore"):
            away = np.abs(values - expected)[chosen] / max(float(np.abs(expected).max()), 1e-9)
        away = np.where(np.isnan(away), np.inf, away)
        at = int(away.argmax())
        found.append(WorstDeviation(name, float(times[chosen][at]), float(away[at]), len(compared)))
    return max(found, key=lambda deviation: deviation.relative)
