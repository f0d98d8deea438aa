"""A table that drives inputs of a system over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.quantity import DTYPES, Type

_SAME_TIME = 1e-9
"""By how much a row may lie after an instant and still count for it, relative to the time."""


@dataclass(frozen=True, eq=False)
class InputColumn:
    """The values of an input, or of one element of it."""

    unit: str
    input: str
    element: int
    """The index of the element among all elements of the input, counted from 0; 0 for a scalar."""
    path: str
    """The full path of the input, or of its element."""
    type: Type
    values: NDArray[Any]
    """In the input's unit of measurement, (rows,)."""
    hold: bool
    """Whether a value holds until the next row; else values are interpolated linearly."""

    def at(self, own: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[Any]:
        """The values at some times; before the first row and after the last one theirs.

        Args:
            own: The times of the rows [s], (rows,).
            times: The times that are asked for [s], (n,).

        Returns:
            The values, (n,).
        """
        if not self.hold:
            return np.interp(times, own, self.values).astype(DTYPES[self.type])
        later = np.searchsorted(own, times + _SAME_TIME * np.maximum(1.0, np.abs(times)), side="right")
        return self.values[np.maximum(later - 1, 0)]


@dataclass(frozen=True, eq=False)
class InputTable:
    """Inputs that follow a table, and the file that it comes from."""

    times: NDArray[np.float64]
    """[s] The time of each row, increasing, (rows,)."""
    columns: tuple[InputColumn, ...]
    hold: bool
    """Whether a person wants all values to hold until the next row."""
    file_suffix: str
    """How the name of the file ends: `.csv` or `.parquet`."""
    content: bytes = field(repr=False)
    """The file as it is, so that a run can be repeated."""

    @property
    def paths(self) -> Iterator[str]:
        """The full paths of the inputs that follow it, in part or whole."""
        yield from dict.fromkeys(f"{column.unit}.{column.input}" for column in self.columns)

    def uncovered(self, start: float, until: float) -> str:
        """A remark on the time of a run that lies outside the table; empty where there is none.

        Args:
            start: The start time of the run [s].
            until: The stop time [s].
        """
        first, last = float(self.times[0]), float(self.times[-1])
        outside = ["before, its first"] if start < first else []
        outside += ["after, its last"] if until > last + _SAME_TIME * max(1.0, abs(last)) else []
        if not outside:
            return ""
        return f"the input table goes from {first:g} s to {last:g} s: {' and '.join(outside)} values are held"
