"""Rows on their way to a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import Type
from orchestrator.stepping.signal_table import RecordedElement


@dataclass(frozen=True)
class RowBatch:
    """Consecutive rows of one group: those of the ticks `first`, `first + every`, ..."""

    group: int
    """Index of the group in `RowLog.elements`."""
    first: int
    every: int
    blocks: Mapping[Type, NDArray[Any]]
    """By type, the values of the group's elements, of shape (rows, elements)."""
    times: NDArray[np.float64]
    """[s] Simulated times of these ticks, of shape (rows,)."""
    step_times: NDArray[np.float64]
    """[s] Wall times of these ticks, of shape (rows,)."""

    def __len__(self) -> int:
        return len(self.step_times)

    @property
    def ticks(self) -> NDArray[np.int64]:
        """The tick of each row, of shape (rows,)."""
        return self.first + self.every * np.arange(len(self), dtype=np.int64)

    def columns(self, elements: Sequence[RecordedElement]) -> dict[str, NDArray[Any]]:
        """The rows as columns.

        Args:
            elements: Those of the group, as `RowLog.elements` gives them.

        Returns:
            Columns of shape (rows,) by name: `time` [s], then one for each element.
        """
        return {"time": self.times} | {e.path: self.blocks[e.type][:, e.position] for e in elements}
