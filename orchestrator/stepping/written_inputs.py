"""Inputs that a program writes during a run, and the values that they received in each row."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY
from orchestrator.system.system import Connection, System


class _Change(NamedTuple):
    """An input that was written or released."""

    tick: int
    """The first tick at which it has an effect."""
    path: str
    value: Any
    """The value that the input is held at; None for one that follows its connection again."""


class WrittenInputs:
    """All inputs of a system that were written so far.

    Args:
        system: The system whose connections drive the inputs otherwise.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        self._changes: list[_Change] = []

    def note(self, tick: int, path: str, value: Any) -> None:
        """Remember that an input is held at a value from a tick on, or follows its connection again (None)."""
        self._changes.append(_Change(tick, path, value))

    def received(self, columns: Mapping[str, Any], ticks: NDArray[np.int64]) -> dict[str, Any]:
        """What each written input received in each row: its connection's values, or those that were written.

        An input is left out where its connection's values were not recorded.

        Args:
            columns: The recorded signal elements, by full path.
            ticks: The tick of each row, (rows,).

        Returns:
            Columns of shape (rows,), by the full path of each element of the inputs.
        """
        received: dict[str, Any] = {}
        for path in dict.fromkeys(change.path for change in self._changes):
            unit, _, _ = path.partition(".")
            for i, element in enumerate(self._system.variable(path, role="inputs").elements):
                driven = self._driven(path, i, columns, len(ticks))
                if driven is None:
                    continue
                values = driven.copy()
                for tick, _, value in (change for change in self._changes if change.path == path):
                    values[ticks >= tick] = driven[ticks >= tick] if value is None else np.ravel(value)[i]
                received[f"{unit}.{element}"] = values
        return received

    def _driven(self, path: str, i: int, columns: Mapping[str, Any], rows: int) -> Any:
        """What drives the element `i` of an input in each row; None where that was not recorded."""
        unit, _, name = path.partition(".")
        wires = [c for c in self._system.connections if (c.unit, c.input) == (unit, name)]
        wire = next((c for c in wires if c.input_element is None or c.input_element.at == i), None)
        if wire is None:
            held = self._system.held.get(path)  # without one, the unit keeps a value that nobody knows
            return np.full(rows, np.nan if held is None else np.ravel(held)[i])
        output = self._system.variable(f"{wire.source}.{wire.output}").elements[_source_element(wire, i)]
        values = columns.get(f"{wire.source}.{output}")
        return values if values is None or wire.conversion == IDENTITY else wire.conversion(values)


def _source_element(wire: Connection, i: int) -> int:
    """The element of the source that drives element `i` of the input."""
    if wire.output_element is not None:
        return wire.output_element.at
    return i if wire.input_element is None else 0
