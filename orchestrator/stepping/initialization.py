"""The initialisation: values travel along the connections in Initialization Mode until nothing changes any more.

In the first pass an input is set only if what drives it has been read: until then it keeps its start value, which only
the unit itself may know.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from components.interfaces.quantity import Type
from fmus.units.unit import Column, Unit, UnitError
from orchestrator.stepping.algebraic_loops import AlgebraicLoop
from orchestrator.stepping.schedule import Schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.system.system import System

INITIALIZATION_PASSES: Final = 100
"""More passes than any chain of units needs; a contracting loop settles within them, too."""


def initialise(
    system: System,
    schedule: Schedule,
    units: Mapping[str, Unit],
    table: SignalTable,
    checked: Callable[[Unit, object], None],
) -> None:
    """Set the inputs and get the outputs of all units, in the order of their dependencies, until they are settled.

    Algebraic loops that the schedule solves are solved here, too.

    Args:
        system: The whole system.
        schedule: Its schedule.
        units: All running units by name, in Initialization Mode.
        table: The signal table that they are bound to.
        checked: Raises an error for the status of a unit's call.

    Raises:
        UnitError: Values keep changing.
    """
    loops = [AlgebraicLoop(system, group, schedule, units, table) for group in schedule.loops]
    outputs = {kind: table.columns[kind][:n] for kind, n in table.recorded.items() if n}
    before: dict[Type, Column] = {}
    _first_pass(system, schedule, units, table, checked)
    solved = {name for group in schedule.loops for name in group}
    for _ in range(INITIALIZATION_PASSES - 1):
        before = {kind: column.copy() for kind, column in outputs.items()}
        for name in schedule.order:
            if name not in solved:
                _pass_on(units[name], table, checked)
        for loop in loops:
            loop.settle()
        if all(_settled(kind, before[kind], column) for kind, column in outputs.items()):
            return
    for unit, path, kind, at in table.elements():
        if not _settled(kind, before[kind][at : at + 1], outputs[kind][at : at + 1]):
            now = f"`{path}` is still {outputs[kind][at]} after {INITIALIZATION_PASSES} passes"
            earlier = f"it was {before[kind][at]} in the pass before"
            raise UnitError(unit, f"the initialisation does not settle: {now}", [earlier])


def _first_pass(
    system: System,
    schedule: Schedule,
    units: Mapping[str, Unit],
    table: SignalTable,
    checked: Callable[[Unit, object], None],
) -> None:
    read: set[str] = set()
    for name in schedule.order:
        unit = units[name]
        waiting = {c.input for c in system.connections_to(name) if c.source not in read}
        if waiting:
            table.bind(unit, waiting)
        _pass_on(unit, table, checked)
        if waiting:
            table.bind(unit)
        read.add(name)


def _pass_on(unit: Unit, table: SignalTable, checked: Callable[[Unit, object], None]) -> None:
    """Set the inputs of a unit, and read its outputs."""
    for function in (*table.giving(unit), *unit.getters()):
        checked(unit, function())


def _settled(kind: Type, before: Column, now: Column) -> bool:
    same = bool((before == now).all())
    return same or (kind.is_float and bool(np.allclose(before, now, rtol=1e-12, atol=1e-14, equal_nan=True)))
