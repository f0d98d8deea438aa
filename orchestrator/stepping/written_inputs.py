"""Inputs and parameters that a program writes during a run, and the values that they received in each row."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY
from components.interfaces.quantity import DTYPES
from components.interfaces.record import Variable
from orchestrator.stepping.tunable_parameters import is_parameter, value_at_start
from orchestrator.system.system import Connection, System


class WrittenValue(NamedTuple):
    """An input or a parameter that was written or released."""

    tick: int
    """The first tick at which it has an effect."""
    path: str
    value: Any
    """The value that it is held at; None for what follows its connection, or has its first value, again."""


class WrittenInputs:
    """All inputs and parameters of a system that were written so far.

    Args:
        system: The system whose connections drive the inputs otherwise.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._changes: list[WrittenValue] = []

    @property
    def changes(self) -> tuple[WrittenValue, ...]:
        """All that was written and released so far."""
        return tuple(self._changes)

    def go_to(self, changes: tuple[WrittenValue, ...]) -> None:
        """Go back to when this was all."""
        self._changes = list(changes)

    def note(self, tick: int, path: str, value: Any) -> None:
        """Remember that something is held at a value from a tick on, or is released again (None)."""
        self._changes.append(WrittenValue(tick, path, deepcopy(value)))  # an array may be used again

    def received(
        self, columns: Mapping[str, Any], ticks: NDArray[np.int64], tabled: Mapping[str, Any] = MappingProxyType({})
    ) -> dict[str, Any]:
        """What each written input or parameter received in each row: its own values, or those that were written.

        An input is left out where its connection's values were not recorded, and what is recorded itself.

        Args:
            columns: The recorded signal elements, by full path.
            ticks: The tick of each row, (rows,).
            tabled: What a table gives to inputs or elements in each row.

        Returns:
            Columns of shape (rows,), by the full path of each element of the inputs.
        """
        received: dict[str, Any] = {}
        for path in dict.fromkeys(change.path for change in self._changes):
            unit, _, _ = path.partition(".")
            role = "parameters" if is_parameter(self._system, path) else "inputs"
            variable = self._system.variable(path, role=role)
            for i, element in enumerate(variable.elements):
                own = self._started if role == "parameters" else self._driven
                driven = tabled.get(f"{unit}.{element}")
                driven = own(variable, path, i, columns, len(ticks)) if driven is None else driven
                if driven is None or f"{unit}.{element}" in columns:
                    continue
                values = driven.copy()
                for tick, _, value in (change for change in self._changes if change.path == path):
                    values[ticks >= tick] = driven[ticks >= tick] if value is None else np.ravel(value)[i]
                received[f"{unit}.{element}"] = values
        return received

    def _started(self, variable: Variable, path: str, i: int, _columns: Mapping[str, Any], rows: int) -> Any:
        """The value that the element `i` of a parameter has from the start on, in each row."""
        value = np.ravel(np.array(value_at_start(self._system, path), dtype=object))[i]
        return np.full(rows, value, dtype=DTYPES[variable.quantity.type])

    def _driven(self, variable: Variable, path: str, i: int, columns: Mapping[str, Any], rows: int) -> Any:
        """What drives the element `i` of an input in each row; None where that was not recorded."""
        unit, _, name = path.partition(".")
        wire = self._system.driver(unit, name, i)
        if wire is None:
            held = self._system.held.get(path)
            if held is None:  # the unit keeps a value that nobody knows
                return np.full(rows, np.nan)
            return np.full(rows, np.ravel(held)[i], dtype=DTYPES[variable.quantity.type])
        output = self._system.variable(f"{wire.source}.{wire.output}").elements[_source_element(wire, i)]
        values = columns.get(f"{wire.source}.{output}")
        return values if values is None or wire.conversion == IDENTITY else wire.conversion(values)


def _source_element(wire: Connection, i: int) -> int:
    """The element of the source that drives element `i` of the input."""
    if wire.output_element is not None:
        return wire.output_element.at
    return i if wire.input_element is None else 0
