"""What an FMU is given while it is measured: inputs near their start values, the same in every passport."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.units.unit import by_type
from orchestrator.exchange.passport.running import Course, start_values
from orchestrator.scenario.suggested_times import suggested_step
from orchestrator.system.experiment import STEP

STEPS: Final = 100
"""The number of steps of most measurements."""
_SHARE_OF_RANGE: Final = 0.05
"""How far from its start value an input is moved, as a share of its declared range."""
_SHARE_OF_SIZE: Final = 0.05
"""The same where no range is declared, as a share of its start value, its nominal value or 1, the largest of them."""


def own_step(archive: Archive) -> float:
    """The step [s] that a run of the FMU alone would take: the one that it suggests, or the macro step."""
    step, _ = suggested_step({"fmu": archive.suggested})
    return step if 0 < step < np.inf else STEP


def usual_steps(archive: Archive, h: float, most: int = STEPS) -> int:
    """How many steps fit into the FMU's default experiment, or `most`: beyond it, some end with an error."""
    stop = archive.suggested.stop
    if stop is None or not np.isfinite(stop):
        return most
    return int(np.clip(round((stop - archive.suggested.start) / h), 1, most))


def amplitudes(archive: Archive) -> dict[Type, NDArray[Any]]:
    """How far each floating-point input is moved from its start value."""
    nominals = {v.name: _number(v.nominal) for v in archive.description.modelVariables}
    starts = start_values(archive)
    found: dict[Type, NDArray[Any]] = {}
    for kind, group in by_type(archive.interface.inputs).items():
        if kind.is_float:
            sizes = np.repeat([_reach(v, nominals.get(v.name)) for v in group], [v.size for v in group])
            ranges = np.repeat([_has_range(v) for v in group], [v.size for v in group])
            found[kind] = np.where(ranges, sizes, np.maximum(sizes, _SHARE_OF_SIZE * np.abs(starts[kind])))
    return found


def course(archive: Archive, h: float, steps: int, seed: int | None) -> Course:
    """The inputs of some steps.

    Args:
        archive: The FMU.
        h: The step [s].
        steps: How many.
        seed: Chooses among courses whose inputs differ in each step; without one they are held, beside their starts.
    """
    random = np.random.default_rng(seed)
    starts, reach = start_values(archive), amplitudes(archive)
    inputs: dict[Type, NDArray[Any]] = {}
    for kind, start in starts.items():
        table = np.repeat(start[None, :], steps, axis=0)
        if kind in reach:
            shares = np.ones(table.shape) if seed is None else random.uniform(-1, 1, table.shape)
            table = _within(archive, kind, table + shares * reach[kind], reach[kind]).astype(start.dtype)
        inputs[kind] = table
    return Course(h, steps, inputs)


def _within(archive: Archive, kind: Type, table: NDArray[Any], reach: NDArray[Any]) -> NDArray[Any]:
    """Values moved into the declared ranges, off their ends where they were outside: many models rest at 0."""
    group = by_type(archive.interface.inputs)[kind]
    low = np.repeat([-np.inf if v.quantity.min is None else v.quantity.min for v in group], [v.size for v in group])
    high = np.repeat([np.inf if v.quantity.max is None else v.quantity.max for v in group], [v.size for v in group])
    inside = np.where(table < low, low + reach, np.where(table > high, high - reach, table))
    return np.clip(inside, low, np.maximum(low, high))


def _reach(variable: Variable, nominal: float | None) -> float:
    q = variable.quantity
    if _has_range(variable) and q.min is not None and q.max is not None:
        return _SHARE_OF_RANGE * (q.max - q.min)
    return _SHARE_OF_SIZE * (abs(nominal) if nominal else 1.0)


def _has_range(variable: Variable) -> bool:
    low, high = variable.quantity.min, variable.quantity.max
    return low is not None and high is not None and 0 < high - low < np.inf


def _number(text: Any) -> float | None:
    try:
        return float(text)
    except (TypeError, ValueError):
        return None
