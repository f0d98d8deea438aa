"""The rows of a run: which signals are kept at which ticks, and where they lie in memory.

Signals that are kept at the same ticks are a group. Without a choice there is one group, everything at every tick;
what is not wanted is not even copied.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from components.interfaces.problem import refuse
from components.interfaces.quantity import DTYPES, Type, zeros
from orchestrator.stepping.finiteness import Finiteness
from orchestrator.stepping.paces import paces
from orchestrator.stepping.row_batch import RowBatch
from orchestrator.stepping.row_group import RowGroup
from orchestrator.stepping.signal_table import RecordedElement, SignalTable
from orchestrator.system.experiment import EVERYTHING, Choice, TimeGrid

LARGEST_LOG: Final = 4 * 2**30
"""[byte] The largest size of all rows; they may be in memory, and a machine runs out of it without a warning."""


ColumnsOfTicks: TypeAlias = Callable[[int, int], Mapping[str, NDArray[Any]]]
"""Gives the rows of the ticks from a first one to before a last one, as `RowLog.columns` does."""

BLOCK: Final = 2**22
"""[byte] About how many rows are in a block of memory."""
KEPT_BLOCKS: Final = 8
"""The blocks that stay in memory, so that what goes wrong with the disk for some time loses nothing."""


class _Block(NamedTuple):
    """Memory for the rows of the ticks from `first` to before `last`."""

    first: int
    last: int
    rows: list[dict[Type, NDArray[Any]]]
    """By group and type."""


class RowLog:
    """All rows of a run, in blocks of memory; the first of them may be dropped when something else has their rows.

    Args:
        table: The signal table.
        grid: The ticks.
        choice: Which signals are kept at every how many ticks.

    Raises:
        RequestError: A pattern fits no signal, or the rows would take too much memory.
    """

    def __init__(self, table: SignalTable, grid: TimeGrid, choice: Choice = EVERYTHING) -> None:
        self.number_kept = np.zeros(1, dtype=np.int64)
        """`kept` in memory, where the native stepper counts while other threads read."""
        self.begun = 0
        """The first tick that has a row; not 0 where the run has begun with a snapshot."""
        self.halted = ""
        """Why the run must not go on, in words; another thread says it."""
        self._length = grid.last_tick + 1
        pace = paces(table.system, choice)
        chosen = [element for element in table.elements() if pace[element.path]]
        size = _size(self._length, [(element.type, pace[element.path]) for element in chosen])
        self.times = grid.times
        """[s] The time of each tick, (ticks,); of the last row it differs where a unit ended between two ticks."""
        self._planned: tuple[int, float] | None = None
        """The tick whose row has another time, and its own."""
        self._order = [element.path for element in chosen]
        self.groups = [
            RowGroup(table, every, [element for element in chosen if pace[element.path] == every])
            for every in sorted({pace[path] for path in self._order})
        ]
        self._blocks: list[_Block] = []
        self._changing = threading.Lock()
        self._elsewhere: ColumnsOfTicks | None = None
        self._block_ticks = max(1, min(self._length, int(BLOCK * self._length / size) if size else self._length))
        self._first, self._last = 0, 0
        self.place = 0
        """Changes with the memory that rows are copied to."""
        self._plain = False
        self._reserve(0)
        # without a choice this is a single group of copies, which need not ask whose tick it is
        self._plain = [group.every for group in self.groups] == [1] and not self.groups[0].picks
        self._copies = self.groups[0].copies if self._plain else []
        self._others = [] if self._plain else self.groups
        self.finiteness = Finiteness(table, self.times)

    @property
    def kept(self) -> int:
        """Number of ticks whose rows are complete, so that another thread may read them."""
        return int(self.number_kept[0])

    @kept.setter
    def kept(self, number: int) -> None:
        self.number_kept[0] = number

    def begin_anew(self) -> None:
        """Forget all rows; those that somebody has been given stay as they are."""
        self.kept, self.halted, self.begun = 0, "", 0
        self._lengthen()
        with self._changing:
            self._blocks, self._elsewhere = [], None
        self._reserve(0)
        self.finiteness.begin_anew()

    def shorten(self, tick: int, time: float) -> None:
        """Give a row, the last one, an earlier time [s] than that of its tick."""
        self._planned = tick, float(self.times[tick])
        self.times[tick] = time

    def _lengthen(self) -> None:
        """Undo `shorten`."""
        if self._planned is not None:
            tick, self.times[tick] = self._planned
            self._planned = None

    def go_to(self, tick: int, *, same_past: bool) -> None:
        """Go back to a tick, or begin at one; the row of the present values is kept.

        Args:
            tick: The tick.
            same_past: Whether the rows up to it, if they are there, are those that led to it.
        """
        if tick < 0:
            self.begin_anew()
            return
        self._lengthen()
        blocks = [block for block in self._blocks if block.first <= tick]
        goes_back = same_past and self.begun <= tick < self.kept
        if blocks and goes_back:
            for group, rows in zip(self.groups, blocks[-1].rows, strict=True):
                group.use(blocks[-1].first, rows)
            with self._changing:
                self._blocks = blocks
            self._copies = self.groups[0].copies if self._plain else []
            self.place += 1
            self._first, self._last = blocks[-1].first, blocks[-1].last
        else:
            with self._changing:
                self._blocks = []
                self._elsewhere = self._elsewhere if goes_back else None
            self.begun = self.begun if goes_back else tick
            self._reserve(tick)
        self.finiteness.go_to(float(self.times[tick]))
        self._copy(tick)
        self.kept = tick + 1

    def keep(self, tick: int) -> bool:
        """Copy the present values to the row of `tick`, and return whether the run may go on with them, kept or not."""
        if tick >= self._last:
            self.reserve(tick)
        self._copy(tick)
        return self.finiteness.holds(tick)

    def _copy(self, tick: int) -> None:
        for rows, values in self._copies:
            rows[tick - self._first] = values
        for group in self._others:
            group.keep(tick)

    def reserve(self, tick: int) -> int:
        """Have memory for the row of a tick, the next one; return the tick from which on more has to be reserved."""
        if tick >= self._last:
            self._reserve(tick)
        return self._last

    def _reserve(self, tick: int) -> None:
        """Begin a block of memory; Ctrl-C may come at any point of it, and then it is done again."""
        last = min(tick + self._block_ticks, self._length)
        block = _Block(tick, last, [group.reserve(tick, last) for group in self.groups])
        with self._changing:
            self._blocks = [*(former for former in self._blocks if former.first < tick), block]
        self._copies = self.groups[0].copies if self._plain else []
        self.place += 1
        self._first, self._last = tick, last

    @property
    def in_memory_from(self) -> int:
        """The first tick whose rows are in memory."""
        return self._blocks[0].first

    def drop(self, before: int, elsewhere: ColumnsOfTicks) -> None:
        """Drop the first rows from memory but for those of the last ticks.

        Args:
            before: The rows of ticks before this one may be dropped.
            elsewhere: Gives them, as `columns` does.
        """
        with self._changing:
            droppable = max(
                0, min(len(self._blocks) - KEPT_BLOCKS, sum(block.last <= before for block in self._blocks))
            )
            if droppable:
                self._elsewhere = elsewhere
                self._blocks = self._blocks[droppable:]

    @property
    def elements(self) -> list[list[RecordedElement]]:
        """The elements of each group, each with its position in the blocks of a batch."""
        return [group.elements for group in self.groups]

    @property
    def at_every_tick(self) -> list[str]:
        """Full paths of the elements that are kept at every tick."""
        return [element.path for group in self.groups if group.every == 1 for element in group.elements]

    def batches(self, first: int, last: int, step_times: NDArray[np.float64]) -> list[RowBatch]:
        """The rows of the ticks from `first` to before `last`, group by group.

        Args:
            first: The first tick.
            last: The tick after the last one.
            step_times: Wall time of each tick of the run [s].
        """
        batches: list[RowBatch] = []
        for i, group in enumerate(self.groups):
            begin, end = group.count(first), group.count(last)
            if begin < end:
                ticks = slice(begin * group.every, last, group.every)
                times = self.times[ticks], step_times[ticks]
                batches.append(RowBatch(i, begin * group.every, group.every, self._rows(i, first, last), *times))
        return batches

    def columns(self, first: int = 0, last: int | None = None) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
        """The rows of the ticks from `first` to before `last`, all so far if not given.

        Returns:
            The ticks at which something was kept, (rows,); and by full path a column for each element, (rows,), in the
            order of the units. Where a signal was not kept at such a tick, its number is NaN and its text empty.
        """
        first, last = max(first, self.begun), self.kept if last is None else last
        due = [group.ticks(first, last) for group in self.groups]
        ticks = self.row_ticks(first, last)
        columns: dict[str, NDArray[Any]] = {}
        for i, (group, own) in enumerate(zip(self.groups, due, strict=True)):
            whole = all(other.every % group.every == 0 for other in self.groups)  # whatever part of the run it is
            rows = self._rows(i, first, last)
            for _, path, kind, at in group.elements:
                values = rows[kind][:, at]
                columns[path] = values.copy() if whole else _spread(values, np.isin(ticks, own), kind)
        return ticks, {path: columns[path] for path in self._order}

    def row_ticks(self, first: int, last: int) -> NDArray[np.int64]:
        """Those of the ticks from `first` to before `last` at which something is kept."""
        if not self.groups or any(group.every == 1 for group in self.groups):
            return np.arange(first, last)
        return np.unique(np.concatenate([group.ticks(first, last) for group in self.groups]))

    def _rows(self, group: int, first: int, last: int) -> dict[Type, NDArray[Any]]:
        """The rows of a group, by type, wherever they are."""
        blocks, elsewhere = self._blocks, self._elsewhere
        count = self.groups[group].count
        parts: list[Mapping[Type, NDArray[Any]]] = []
        if elsewhere is not None and first < blocks[0].first:
            parts.append(self._stacked(group, first, min(last, blocks[0].first), elsewhere))
        for block in blocks:
            begin, end = max(first, block.first), min(last, block.last)
            if begin < end:
                own = slice(count(begin) - count(block.first), count(end) - count(block.first))
                parts.append({kind: rows[own] for kind, rows in block.rows[group].items()})
        if len(parts) == 1:
            return dict(parts[0])
        none = {kind: rows[:0] for kind, rows in blocks[0].rows[group].items()}
        return {kind: np.concatenate([none[kind], *(part[kind] for part in parts)]) for kind in none}

    def _stacked(self, group: int, first: int, last: int, elsewhere: ColumnsOfTicks) -> dict[Type, NDArray[Any]]:
        """The same from columns."""
        own = self.groups[group]
        columns, mine = elsewhere(first, last), np.isin(self.row_ticks(first, last), own.ticks(first, last))
        kinds = dict.fromkeys(element.type for element in own.elements)
        return {
            kind: np.stack([columns[e.path][mine] for e in own.elements if e.type is kind], axis=1).astype(DTYPES[kind])
            for kind in kinds
        }


def _spread(values: NDArray[Any], where: NDArray[np.bool_], kind: Type) -> NDArray[Any]:
    whole = np.full(len(where), np.nan) if kind.is_number else zeros(kind, len(where))
    whole[where] = values
    return whole


def _size(length: int, kept: Iterable[tuple[Type, int]]) -> int:
    """[byte] The size of all rows. Raises `RequestError` where that is too large."""
    size = sum(-(-length // every) * np.dtype(DTYPES[kind]).itemsize for kind, every in kept)
    if size > LARGEST_LOG:
        raise refuse(
            "stop time",
            f"{length} ticks, {size / 2**30:.3g} GiB of rows",
            f"at most {LARGEST_LOG / 2**30:g} GiB of rows",
            "Take a shorter run, a larger step or less to record.",
        )
    return size
