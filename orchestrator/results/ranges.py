"""Outputs outside the range that their unit declares for them: where its model is not valid any more."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from components.interfaces.problem import listed

if TYPE_CHECKING:  # opening a recording needs the remarks only
    from orchestrator.system.system import System

_SLACK = 1e-9
"""How far outside a value may be, relative to its size: a rounding error."""


def out_of_range(rows: Mapping[str, Any], system: System) -> dict[str, dict[str, Any]]:
    """Where signals first leave the range that their unit declares (`min` and `max` of its outputs).

    Args:
        rows: The columns of a run; values that are not finite do not count.
        system: What was run.

    Returns:
        The time [s], the value and the declared range of the first row outside, by signal element.
    """
    found: dict[str, dict[str, Any]] = {}
    for unit in system.units:
        for variable in system.names(unit, "outputs").variables.values():
            declared = variable.quantity
            if not declared.type.is_number or (declared.min is None and declared.max is None):
                continue
            for path in (f"{unit}.{element}" for element in variable.elements):
                if path in rows and (row := _first(np.asarray(rows[path], float), declared.min, declared.max)) >= 0:
                    value, time = float(rows[path][row]), float(rows["time"][row])
                    found[path] = {"time": time, "value": value, "declared": declared.range}
    return found


def _first(values: np.ndarray[Any, Any], low: float | None, high: float | None) -> int:
    """The first row that is outside; -1 where none is."""
    slack = _SLACK * np.maximum(1.0, np.abs(values))
    outside = np.zeros(values.shape, dtype=bool)
    if low is not None:
        outside |= values < low - slack
    if high is not None:
        outside |= values > high + slack
    outside &= np.isfinite(values)
    return int(np.argmax(outside)) if outside.any() else -1


def range_remarks(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A remark on each unit that has left its declared ranges, as `out_of_range` has found."""
    of_unit: dict[str, list[str]] = {}
    for path in sorted(found, key=lambda p: found[p]["time"]):
        of_unit.setdefault(path.partition(".")[0], []).append(path)
    remarks: list[str] = []
    for paths in of_unit.values():
        first, others = found[paths[0]], listed([f"`{p}`" for p in paths[1:]])
        text = f"`{paths[0]}` is {first['value']:.6g} at t = {first['time']:g} s, outside of what its unit declares"
        remarks.append(f"{text} ({first['declared']})" + (f"; so are later {others}" if others else ""))
    return remarks
