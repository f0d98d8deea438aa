"""Signals that are kept at the same ticks, and where their rows lie in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import Type, zeros
from orchestrator.stepping.signal_table import RecordedElement, SignalTable


class RowGroup:
    """Signals that are kept at every `every`-th tick, and where the rows of a block of ticks are copied to."""

    def __init__(self, table: SignalTable, every: int, chosen: Sequence[RecordedElement]) -> None:
        self.every = every
        self.elements: list[RecordedElement] = []
        """The chosen elements by type, each with its index among the rows of that type."""
        self._values: dict[Type, tuple[NDArray[Any], NDArray[np.int64] | None]] = {}
        """By type, values in the table, and the places of those that are kept; none where these lie side by side."""
        self._widths: dict[Type, int] = {}
        self.begin = 0
        """The row of the first tick of the present block."""
        self.copies: list[tuple[NDArray[Any], NDArray[Any]]] = []
        """Rows, and the values that lie side by side in the table."""
        self.picks: list[tuple[NDArray[Any], NDArray[Any], NDArray[np.int64]]] = []
        """Rows, values, and the places of those that are kept."""
        for kind in dict.fromkeys(element.type for element in chosen):
            of_kind = [element for element in chosen if element.type is kind]
            self.elements += [element._replace(position=i) for i, element in enumerate(of_kind)]
            at = np.array([element.position for element in of_kind])
            self._widths[kind] = len(at)
            if (np.diff(at) == 1).all():
                self._values[kind] = table.columns[kind][at[0] : at[-1] + 1], None
            else:
                self._values[kind] = table.columns[kind], at

    def reserve(self, first: int, last: int) -> dict[Type, NDArray[Any]]:
        """Memory for the rows of the ticks from `first` to before `last`, to which rows are copied from now on."""
        count = self.count(last) - self.count(first)
        rows = {kind: zeros(kind, (count, n)) for kind, n in self._widths.items()}
        self.use(first, rows)
        return rows

    def use(self, first: int, rows: Mapping[Type, NDArray[Any]]) -> None:
        """Copy rows from now on to memory that `reserve` gave for the ticks from `first` on."""
        self.begin = self.count(first)
        self.copies = [(rows[kind], values) for kind, (values, places) in self._values.items() if places is None]
        self.picks = [(rows[k], values, places) for k, (values, places) in self._values.items() if places is not None]

    def keep(self, tick: int) -> None:
        """Copy the present values, if it is their tick."""
        row, other = divmod(tick, self.every)
        if not other:
            row -= self.begin
            for rows, values in self.copies:
                rows[row] = values
            for rows, values, places in self.picks:
                values.take(places, 0, rows[row], "clip")  # "clip": no copy between; all places are in range

    def ticks(self, first: int, last: int) -> NDArray[np.int64]:
        """Those of the ticks from `first` to before `last` that have a row."""
        return np.arange(self.count(first) * self.every, last, self.every)

    def count(self, ticks: int) -> int:
        """How many rows the ticks before `ticks` have."""
        return -(-ticks // self.every)
