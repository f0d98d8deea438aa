"""The rows of a run: which signals are kept at which ticks, and where they lie in memory.

Signals that are kept at the same ticks are a group. Without a choice there is one group, everything at every tick;
what is not wanted is not even copied.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.quantity import DTYPES, Type, zeros
from orchestrator.stepping.finiteness import Finiteness
from orchestrator.stepping.observation import applied
from orchestrator.stepping.signal_table import RecordedElement, SignalTable
from orchestrator.system.experiment import EVERYTHING, Choice, TimeGrid
from orchestrator.system.patterns import fits
from orchestrator.system.system import System

LARGEST_LOG: Final = 4 * 2**30
"""[byte] The largest size of all rows; they are kept in memory, and a machine runs out of it without a warning."""


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


class _Group:
    """Memory for the rows of signals that are kept at every `every`-th tick."""

    def __init__(self, table: SignalTable, every: int, chosen: Sequence[RecordedElement], ticks: int) -> None:
        self.every = every
        self.rows: dict[Type, NDArray[Any]] = {}
        self.elements: list[RecordedElement] = []
        """The chosen elements by type, each with its index among the rows of that type."""
        self.copies: list[tuple[NDArray[Any], NDArray[Any]]] = []
        """Rows, and the values that lie side by side in the table."""
        self.picks: list[tuple[NDArray[Any], NDArray[Any], NDArray[np.int64]]] = []
        """Rows, values, and the places of those that are kept."""
        for kind in dict.fromkeys(element.type for element in chosen):
            of_kind = [element for element in chosen if element.type is kind]
            self.elements += [element._replace(position=i) for i, element in enumerate(of_kind)]
            at = np.array([element.position for element in of_kind])
            self.rows[kind] = zeros(kind, (self.count(ticks), len(at)))
            if (np.diff(at) == 1).all():
                self.copies.append((self.rows[kind], table.columns[kind][at[0] : at[-1] + 1]))
            else:
                self.picks.append((self.rows[kind], table.columns[kind], at))

    def keep(self, tick: int) -> None:
        """Copy the present values, if it is their tick."""
        row, other = divmod(tick, self.every)
        if not other:
            for rows, values in self.copies:
                rows[row] = values
            for rows, values, places in self.picks:
                values.take(places, 0, rows[row], "clip")  # "clip": no copy between; all places are in range

    def count(self, ticks: int) -> int:
        """How many rows the ticks before `ticks` have."""
        return -(-ticks // self.every)


class RowLog:
    """All rows of a run, in memory that is reserved at the start.

    Args:
        table: The signal table.
        grid: The ticks.
        choice: Which signals are kept at every how many ticks.

    Raises:
        RequestError: A pattern fits no signal, or the rows would take too much memory.
    """

    def __init__(self, table: SignalTable, grid: TimeGrid, choice: Choice = EVERYTHING) -> None:
        self.kept = 0
        """Number of ticks whose rows are complete, so that another thread may read them."""
        length = grid.last_tick + 1
        pace = paces(table.system, choice)
        chosen = [element for element in table.elements() if pace[element.path]]
        _refuse_too_large(length, [(element.type, pace[element.path]) for element in chosen])
        self.times = grid.times
        """[s] The time of each tick, (ticks,); of the last row it differs where a unit ended between two ticks."""
        self._order = [element.path for element in chosen]
        self._groups = [
            _Group(table, every, [element for element in chosen if pace[element.path] == every], length)
            for every in sorted({pace[path] for path in self._order})
        ]
        # without a choice this is a single group of copies, which need not ask whose tick it is
        plain = [group.every for group in self._groups] == [1] and not self._groups[0].picks
        self._copies = self._groups[0].copies if plain else []
        self._others = [] if plain else self._groups
        self.finiteness = Finiteness(table, self.times)

    def keep(self, tick: int) -> bool:
        """Copy the present values to the row of `tick`, and return whether the run may go on with them, kept or not."""
        for rows, values in self._copies:
            rows[tick] = values
        for group in self._others:
            group.keep(tick)
        return self.finiteness.holds(tick)

    @property
    def elements(self) -> list[list[RecordedElement]]:
        """The elements of each group, each with its position in the blocks of a batch."""
        return [group.elements for group in self._groups]

    @property
    def at_every_tick(self) -> list[str]:
        """Full paths of the elements that are kept at every tick."""
        return [element.path for group in self._groups if group.every == 1 for element in group.elements]

    def batches(self, first: int, last: int, step_times: NDArray[np.float64]) -> list[RowBatch]:
        """The rows of the ticks from `first` to before `last`, group by group.

        Args:
            first: The first tick.
            last: The tick after the last one.
            step_times: Wall time of each tick of the run [s].
        """
        batches: list[RowBatch] = []
        for i, group in enumerate(self._groups):
            begin, end = group.count(first), group.count(last)
            if begin < end:
                blocks = {kind: rows[begin:end] for kind, rows in group.rows.items()}
                ticks = slice(begin * group.every, last, group.every)
                times = self.times[ticks], step_times[ticks]
                batches.append(RowBatch(i, begin * group.every, group.every, blocks, *times))
        return batches

    def columns(self) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
        """All rows so far.

        Returns:
            The ticks at which something was kept, (rows,); and by full path a column for each element, (rows,), in the
            order of the units. Where a signal was not kept at such a tick, its number is NaN and its text empty.
        """
        due = [np.arange(0, self.kept, group.every) for group in self._groups]
        ticks = np.unique(np.concatenate(due)) if due else np.arange(self.kept)
        columns: dict[str, NDArray[Any]] = {}
        for group, own in zip(self._groups, due, strict=True):
            for _, path, kind, at in group.elements:
                columns[path] = _spread(group.rows[kind][: len(own), at], np.isin(ticks, own), kind)
        return ticks, {path: columns[path] for path in self._order}


def _spread(values: NDArray[Any], where: NDArray[np.bool_], kind: Type) -> NDArray[Any]:
    if where.all():
        return values.copy()
    whole = np.full(len(where), np.nan) if kind.is_number else zeros(kind, len(where))
    whole[where] = values
    return whole


def paces(system: System, choice: Choice) -> dict[str, int]:
    """At every how many ticks each element of what units show is kept.

    A signal that fits no pattern is not kept, unless all patterns only leave something out.

    Args:
        system: The system whose signals are kept.
        choice: Pattern by pattern, at every how many ticks.

    Returns:
        Numbers of ticks by full path of an element, 0 for never.

    Raises:
        RequestError: A pattern fits no signal.
    """
    raise_if_any(_unfitting(system, choice))
    found: dict[str, int] = {}
    for unit, source in system.units.items():
        outputs = len(source.interface.outputs)
        of_outputs, of_others = (applied(choice, source, to_outputs=is_output) for is_output in (True, False))
        for i, variable in enumerate(source.interface.recorded):
            pace = (of_outputs if i < outputs else of_others).pace(f"{unit}.{variable.name}")
            found |= dict.fromkeys((f"{unit}.{element}" for element in variable.elements), min(pace, _ONCE))
    return found


def _unfitting(system: System, choice: Choice) -> Iterator[Problem]:
    """The problems of patterns that no signal fits; that of everything fits a system that has none."""
    paths = [f"{unit}.{v.name}" for unit, source in system.units.items() for v in source.interface.recorded]
    for pattern in choice:
        if pattern in EVERYTHING or any(fits(path, pattern) for path in paths):
            continue
        others = [f"{unit}.{name}" for unit, source in system.units.items() for name in source.observable]
        if not any(fits(path, pattern) for path in others):
            known = [*paths, *others]
            yield Problem(f"record {pattern}", "a pattern that no signal fits", choices(paths), _meant(pattern, known))


def _meant(pattern: str, paths: Iterable[str]) -> str:
    if any(path.startswith(f"{pattern}.") for path in paths):  # a unit, or a bus
        return f"Did you mean `{pattern}.*`?"
    return did_you_mean(pattern, paths)


_ONCE: Final = 2**31
"""[ticks] No run is as long, so that a signal of this pace or a larger one is kept at the start only."""


def without_gaps(system: System, choice: Choice) -> set[str]:
    """Full paths of the elements that are kept in every row: those at every tick, or all if all have the same pace."""
    kept = {path: every for path, every in paces(system, choice).items() if every}
    return {path for path, every in kept.items() if every == 1 or len(set(kept.values())) == 1}


def _refuse_too_large(length: int, kept: Iterable[tuple[Type, int]]) -> None:
    rows = sum(-(-length // every) * np.dtype(DTYPES[kind]).itemsize for kind, every in kept)
    if rows > LARGEST_LOG:
        raise refuse(
            "stop time",
            f"{length} ticks, {rows / 2**30:.3g} GiB of rows",
            f"at most {LARGEST_LOG / 2**30:g} GiB of rows",
            "Take a shorter run, a larger step or less to record.",
        )
