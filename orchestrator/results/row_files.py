"""The rows of a run go to disk as they come: files that `pandas.read_parquet` reads at any time, one file at the end.

A thread writes what has come since it wrote last, whatever the simulation does meanwhile. The last file is written anew
with more rows until it is large, so that a slow run has few files. Each has its name when it is complete.
"""

from __future__ import annotations

import threading
import time
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

import numpy as np

from orchestrator.results.live_folder import LiveFolder
from orchestrator.results.manifest import reason
from orchestrator.results.parquet import FileColumns, SignalSchema, merge, read_columns
from orchestrator.results.run_folder import MEANING, PART, ROWS, SIGNALS
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import Scenario

INTERVAL: Final = 0.5
"""[s] Wall time between two writings."""
_LARGE: Final = 2**22
"""[byte] Values of a file that does not grow any more."""
_PATIENCE: Final = 5.0
"""[s] For how long rows may not be written before the run ends."""


@dataclass(frozen=True)
class _Part:
    """A file with the rows of the ticks from `first` to before `last`."""

    first: int
    last: int
    name: str


class RowFiles:
    """Writes the rows of a simulation to its run folder; to be used in a `with` statement.

    Args:
        folder: The run folder.
        scenario: What is run.
        simulation: The simulation, which may step meanwhile.
    """

    def __init__(self, folder: LiveFolder, scenario: Scenario, simulation: Simulation) -> None:
        self._folder, self._simulation = folder, simulation
        self._schema = SignalSchema(simulation.rows(0, 0), scenario)
        self._largest = max(1, _LARGE // self._schema.row_size)
        self._begin, self._parts = 0, list[_Part]()
        self._grows = False
        """Whether the last part is written anew with more rows."""
        self._merged = False
        self._ending, self._files = threading.Event(), threading.Lock()
        self.problem = ""
        """Why rows are not on disk, in words; empty where all are."""
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()

    def finish(self) -> None:
        """Write the rows that have come, and all of them as one file; `problem` tells what went wrong."""
        self._stop()
        self._try(to_the_last=True)
        if self.problem:
            return
        with self._files:
            self._restore_parts()
            rows = self._rows
            try:
                merge([rows / part.name for part in self._parts], rows / MEANING, self._folder.path / SIGNALS)
            except OSError as error:
                self.problem = f"{SIGNALS} cannot be written ({reason(error)}); the rows are in {ROWS}/"
                return
            self._merged = True
            if self._begin:
                at = f"{self._simulation.log.times[self._begin]:g} s"
                self.problem = f"the rows before {at} are gone: {self._folder.named} has those that came later"
            for name in (*(part.name for part in self._parts), MEANING):
                (rows / name).unlink(missing_ok=True)
            with suppress(OSError):  # somebody has put other things there
                rows.rmdir()

    def columns(self) -> Mapping[str, Any]:
        """All rows that there are, by column."""
        if not self._simulation.log.in_memory_from:
            return self._simulation.columns()
        if self._merged:
            return FileColumns(self._folder.path / SIGNALS)
        return self._simulation.rows(self._simulation.log.in_memory_from, self._simulation.log.kept)

    @property
    def _rows(self) -> Path:
        return self._folder.path / ROWS

    @property
    def _written(self) -> int:
        """The first tick whose row is not on disk."""
        return self._parts[-1].last if self._parts else self._begin

    def _stop(self) -> None:
        self._ending.set()
        if self._thread.is_alive():
            self._thread.join()

    def _work(self) -> None:
        fine = time.monotonic()
        while not self._ending.wait(INTERVAL):
            self._try()
            if not self.problem:
                fine = time.monotonic()
                first = self._parts[-1].first if self._grows else self._written
                self._simulation.log.drop(first, self._read)
            elif time.monotonic() - fine > _PATIENCE:
                self._simulation.log.halted = self.problem

    def _try(self, *, to_the_last: bool = False) -> None:
        """Write what has come, and to the last row that the disk takes if that is wanted."""
        try:
            self._write(self._simulation.log.kept, to_the_last=to_the_last)
        except OSError as error:
            self.problem = f"rows cannot be written to {self._folder.named} ({reason(error)}){self._saved()}"
        except Exception as error:  # noqa: BLE001 - whatever it is, the run ends in words
            self.problem = f"rows cannot be written ({type(error).__name__}: {error})"
        else:
            self.problem = ""

    def _saved(self) -> str:
        """Where the rows are that could be written, in words."""
        at = self._simulation.log.times[self._written - 1] if self._written > self._begin else None
        return "" if at is None else f"; those up to {at:g} s are in {ROWS}/"

    def _write(self, kept: int, *, to_the_last: bool) -> None:
        """Write the rows that came since this was called last, and the first time that there are none yet."""
        if not self._folder.follow():  # it was removed, with all that was in it
            self._parts, self._grows, self._begin = [], False, self._simulation.log.in_memory_from
        if not (self._rows / MEANING).is_file():
            self._rows.mkdir(exist_ok=True)
            self._schema.write_meaning(self._rows / MEANING)
        most = self._largest
        while self._written < kept or not self._parts:
            first = self._parts[-1].first if self._grows else self._written
            last = min(kept, first + (self._largest if self._grows else most))
            number = len(self._parts) if self._grows else len(self._parts) + 1
            part = _Part(first, last, PART.replace("*", f"{number:06}"))
            try:
                self._write_part(part)
            except OSError:
                # There may be room for the new rows alone, if not for all of a part.
                most = most if self._grows else (last - first) // 2
                self._grows = False
                if not (to_the_last and most):
                    raise
                continue
            self._parts = [*(self._parts[:-1] if self._grows else self._parts), part]
            self._grows = last - first < self._largest

    def _write_part(self, part: _Part) -> None:
        self._schema.write_part(self._simulation.rows(part.first, part.last), self._rows / part.name)

    def _restore_parts(self) -> None:
        """Write again what somebody has removed, as far as it is still in memory."""
        for part in self._parts:
            if not (self._rows / part.name).is_file() and part.first >= self._simulation.log.in_memory_from:
                with suppress(OSError):
                    self._write_part(part)

    def _read(self, first: int, last: int) -> Mapping[str, Any]:
        """The rows of the ticks from `first` to before `last`, from the files."""
        with self._files:
            if self._merged:
                ticks = self._simulation.log.row_ticks(0, last)
                rows = slice(int(np.searchsorted(ticks, first)), len(ticks))
                return read_columns(self._folder.path / SIGNALS, rows=rows)
            found = [self._part_columns(part, first, last) for part in self._overlapping(first, last)]
        return {name: np.concatenate([part[name] for part in found]) for name in found[0]}

    def _overlapping(self, first: int, last: int) -> Iterator[_Part]:
        begin = bisect_right(self._parts, first, key=lambda part: part.last)
        for part in self._parts[begin:]:
            if part.first >= last:
                return
            yield part

    def _part_columns(self, part: _Part, first: int, last: int) -> Mapping[str, Any]:
        ticks = self._simulation.log.row_ticks(part.first, part.last)
        mine = (ticks >= first) & (ticks < last)
        return {name: values[mine] for name, values in read_columns(self._rows / part.name).items()}
