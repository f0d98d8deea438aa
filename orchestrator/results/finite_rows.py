"""Rows in which all numbers of some buses are finite: only these count for a metric of the buses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd

Frame: TypeAlias = "pd.DataFrame | Mapping[str, NDArray[Any]]"
"""The rows of a run: the column `time` [s], and one column for each signal element."""


class FiniteColumns:
    """Which numbers of a run are finite, of which each column is looked at once."""

    def __init__(self, frame: Frame) -> None:
        self._frame = frame
        self._names = tuple(map(str, frame))
        self._known: dict[str, NDArray[np.bool_] | None] = {}

    def rows(self, buses: Iterable[str], until: int | None) -> FiniteRows:
        """The rows before one in which all numbers of some buses are finite."""
        wrong = [here for n in _of_buses(self._names, tuple(buses)) if (here := self._finite(n)) is not None]
        if until is None and not wrong:
            return FiniteRows(self._frame, self._names, None)
        finite = np.ones(len(self._frame["time"]), dtype=bool)
        for here in wrong:
            finite &= here
        if until is not None:
            finite[until:] = False
        return FiniteRows(self._frame, self._names, finite)

    def _finite(self, name: str) -> NDArray[np.bool_] | None:
        """Which numbers of a column are finite; None where all are."""
        if name not in self._known:
            values = np.asarray(self._frame[name])
            finite = np.isfinite(values) if values.dtype.kind == "f" else None  # the others are, or are no numbers
            self._known[name] = None if finite is None or finite.all() else finite
        return self._known[name]


@lru_cache(maxsize=256)  # the columns of many runs have the same names
def _of_buses(names: tuple[str, ...], buses: tuple[str, ...]) -> list[str]:
    """The columns of some buses."""
    beginnings = tuple(f"{bus}." for bus in buses)
    return [name for name in names if name.startswith(beginnings)]


class FiniteRows(Mapping[str, NDArray[Any]]):
    """Some rows; columns are taken when they are asked for."""

    def __init__(self, frame: Frame, names: Sequence[str], finite: NDArray[np.bool_] | None) -> None:
        self._frame, self._names, self._finite = frame, names, finite

    def __getitem__(self, name: str) -> NDArray[Any]:
        values = np.asarray(self._frame[name])
        return values if self._finite is None else values[self._finite]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
