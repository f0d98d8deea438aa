"""Inputs that follow a table: their values at each tick, computed once, and copied to where the units read them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import Type
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.system.input_table import InputColumn


class TableInputs:
    """The inputs of a system that follow its table, if it has one.

    Args:
        table: The signal table.
        times: The time of each tick [s], (ticks,).
    """

    def __init__(self, table: SignalTable, times: NDArray[np.float64]) -> None:
        self._table = table
        given = table.system.table
        self._columns: tuple[InputColumn, ...] = () if given is None else given.columns
        self._values = {} if given is None else {c.path: c.at(given.times, times) for c in self._columns}
        self.copies: list[tuple[NDArray[Any], NDArray[np.intp], NDArray[Any]]] = []
        """Columns of the signal table, places in them, and the values of these at each tick, (ticks, places)."""

    def prepare(self, tick: int) -> None:
        """Follow the table from now on, but for the inputs that are held; they have the values of a tick at once."""
        by_type: dict[Type, list[InputColumn]] = {}
        for column in self._columns:
            if not self._table.is_held(column.unit, column.input):
                by_type.setdefault(column.type, []).append(column)
        self.copies = [
            (
                self._table.columns[kind],
                np.array([self._table.slots(c.unit, c.input, "inputs")[1].start + c.element for c in columns]),
                np.ascontiguousarray(
                    np.stack([self._values[c.path] for c in columns], axis=1), self._table.columns[kind].dtype
                ),
            )
            for kind, columns in by_type.items()
        ]
        self.apply(tick)

    def apply(self, tick: int) -> None:
        """Give the inputs their values at a tick."""
        for column, places, rows in self.copies:
            column[places] = rows[tick]

    def received(self, ticks: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """The values of the table at some ticks, by the full path of each input or element."""
        return {path: values[ticks] for path, values in self._values.items()}
