"""How messages put the variables that stand for signals into words."""

from __future__ import annotations

from collections.abc import Sequence

from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from fmus.units.adaptation import Link
from orchestrator.mapping.fitting_result import FittedSignal, Remark

_MOST = 3
"""The number of names that are listed one by one."""


def decision(signal: Variable, theirs: Sequence[Variable], link: Link) -> str:
    """The decision on a signal that no mapping file gave, as text; empty where none was necessary."""
    q, ours = theirs[0].quantity, signal.quantity
    parts: list[str] = []
    if ours.type.is_float and q.type.is_float and q.unit != ours.unit:
        parts.append(f"[{q.unit}]" if q.unit else f"without a unit, taken as {ours.unit}")
    if q.type != ours.type:
        parts.append(f"{q.type}")
    if signal.shape and 0 < len(link.theirs) < signal.shape[0]:
        parts.append(f"{len(link.theirs)} of {signal.shape[0]} slots")
    if not parts and [v.name for v in theirs] != [signal.name]:
        return "by its name"
    return ", ".join(parts)


def decision_remark(unit: str, row: FittedSignal, names: Sequence[str], note: str) -> Remark:
    """One decision in one line: `plant.state.v_x <- car.speed, [km/h]`."""
    arrow = "<-" if row.direction == "outputs" else "->"
    return Remark(f"{unit}.{row.signal.name} {arrow} {listed(names)}, {note}", row.signal.name)


def listed(names: Sequence[str]) -> str:
    """Names in one line; of many the first and the last."""
    return ", ".join(names) if len(names) <= _MOST else f"{names[0]} ... {names[-1]}"


def offer(theirs: Interface) -> str:
    """What an FMU reads and shows, in one line."""
    return "; ".join(
        f"its {direction} {', '.join(_with_unit(v) for v in found) or 'nothing'}"
        for direction, found in (("inputs", theirs.inputs), ("outputs", theirs.outputs))
    )


def _with_unit(variable: Variable) -> str:
    unit = variable.quantity.unit if variable.quantity.type.is_float else ""
    size = f"[{', '.join(map(str, variable.shape))}]" if variable.shape else ""
    return f"{variable.name}{size} in {unit}" if unit else f"{variable.name}{size}"
