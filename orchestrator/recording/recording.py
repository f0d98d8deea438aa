"""Writes `recording.rrd`: soon after each step while the run lasts, and compact at the end.

A recording is compact if it is written in batches of hundreds of rows, but a run that is killed should lose the rows of
no more than a second. A slow run therefore writes two files: the recording, with a small batch every second, and a
compact file in large batches, which replaces the recording when the run has ended.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from orchestrator.recording.messages import RecordingRequest
from orchestrator.recording.process import recorded_by_process
from orchestrator.results.manifest import unfinished
from orchestrator.results.run_folder import SYSTEM
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp.archive import removed_packages
from orchestrator.stepping.row_batch import RowBatch
from orchestrator.system.experiment import Scenario

if TYPE_CHECKING:  # slow to import, and only the names are needed
    from orchestrator.recording.stream import RerunStream
    from orchestrator.stepping.master import Simulation

LARGE: Final = 600
"""Rows of a batch; in a larger one a row hardly takes less space."""
_SHORT: Final = 150
"""Rows of a batch below which it is joined with its predecessor, because every batch has a header for each entity."""
_SLOW: Final = 200
"""Rows; a run whose first batch has fewer of them gets a compact file as well."""


_MOST_IN_MEMORY: Final = 2_000_000
"""Values of a recording that is made in this process; a process of its own writes larger ones."""


class Recording:
    """The recording of one run, in a file or in the viewer at a URL.

    Args:
        request: What to record, and where.
        scenario: What is run.
        at_once: Whether a file is written at the end, as a whole.
    """

    def __init__(self, request: RecordingRequest, scenario: Scenario, *, at_once: bool = False) -> None:
        self._request, self._scenario, self._at_once = request, scenario, at_once
        self._file = request.sink if isinstance(request.sink, Path) and not at_once else None
        self._stream = self._open(None if at_once else request.sink)
        self._is_watched = isinstance(request.sink, str) or request.followed
        if self._is_watched:
            self._stream.send_layout()
        if self._file is not None:
            self._stream.flush()  # from here on there is a file, however the run ends
        self._compact: RerunStream | None = None
        self._pending: list[RowBatch] = []
        self._begun = False

    def log(self, batches: Sequence[RowBatch], *, last: bool = False) -> None:
        """Write rows.

        Args:
            batches: Rows that follow those of the last call.
            last: Whether all rows of the run have come; if they come at once, one file is compact already.
        """
        is_slow = not self._begun and not last and sum(map(len, batches)) < _SLOW
        if is_slow and self._file is not None and not self._request.followed:
            self._compact = self._open(_compact_file(self._file))
        if not self._begun and not last and not self._is_watched:  # the run may be killed from here on
            self._stream.send_layout()
        self._begun = True
        self._send(self._stream, batches)
        if self._file is not None:  # a viewer takes the rows at its own pace
            self._stream.flush()
        if self._compact is not None:
            self._pending += batches
            if sum(map(len, self._pending)) >= 2 * LARGE:  # few rows are then left for the end
                self._send(self._compact, joined(self._pending))
                self._pending = []

    def close(self, about: Mapping[str, str]) -> None:
        """Write what is left, and replace the recording by the compact file if there is one.

        Args:
            about: The run's provenance as it is known at the end.
        """
        if self._compact is None or self._file is None:
            whole = self._stream.close(about)
            if self._at_once and isinstance(self._request.sink, Path):
                with unfinished(self._request.sink) as file:
                    file.write_bytes(whole)
            return
        self._send(self._compact, joined(self._pending))
        self._compact.close(about)
        self._stream.close(about)
        _compact_file(self._file).replace(self._file)

    def _open(self, sink: Path | str | None) -> RerunStream:
        from orchestrator.recording.stream import RerunStream  # noqa: PLC0415

        scenario = self._scenario
        return RerunStream(
            sink,
            scenario.system,
            scenario.scene,
            name=self._request.name or scenario.name,
            grid=scenario.grid,
            about=self._request.about,
            recorded=[[element.path for element in group] for group in self._request.elements],
            recording_id=self._request.recording_id,
            followed=self._request.followed,
        )

    def _send(self, stream: RerunStream, batches: Sequence[RowBatch]) -> None:
        for batch in batches:
            columns = batch.columns(self._request.elements[batch.group])
            stream.log(columns, batch.step_times if batch.group == 0 else None)


class Afterwards:
    """A recorder that works in this process when the run is over, for many short runs."""

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Remember what to record."""
        self._request, self._simulation = request, simulation

    def wait_until_open(self) -> None:
        """Nothing is written before the end."""

    def end(self, about: Mapping[str, str]) -> None:
        """Remember the provenance of the run as it is known at the end."""
        self._about = about

    def wait(self) -> str:
        """Write the recording.

        Returns:
            What went wrong, in a line; empty if nothing did.
        """
        log, request = self._simulation.log, self._request
        if log.kept * sum(map(len, log.elements)) > _MOST_IN_MEMORY:
            return recorded_by_process(request, self._simulation, self._about)
        try:
            with removed_packages():
                recording = Recording(request, ssp_reader.read(request.folder / SYSTEM), at_once=True)
            for first in range(0, log.kept, LARGE):
                last = min(first + LARGE, log.kept)
                recording.log(log.batches(first, last, self._simulation.step_times), last=True)
            recording.close(self._about)
        except Exception as error:  # noqa: BLE001 - the recording is best effort: the run is kept, and a note tells
            return f"{type(error).__name__}: {error}"
        return ""


def _compact_file(file: Path) -> Path:
    return file.with_name(f".{file.name}")


def joined(batches: Sequence[RowBatch]) -> list[RowBatch]:
    """Join batches.

    Args:
        batches: Consecutive rows of each group, in any order.

    Returns:
        The same rows in few batches by group, none of them much longer than `LARGE`, and no short one after another.
    """
    runs: list[list[RowBatch]] = []
    for batch in sorted(batches, key=lambda b: (b.group, b.first)):
        if runs and runs[-1][0].group == batch.group and sum(map(len, runs[-1])) < LARGE:
            runs[-1].append(batch)
        else:
            runs.append([batch])
    for i in range(len(runs) - 1, 0, -1):
        if runs[i][0].group == runs[i - 1][0].group and sum(map(len, runs[i])) < _SHORT:
            runs[i - 1] += runs.pop(i)
    return [_whole(parts) for parts in runs]


def _whole(parts: Sequence[RowBatch]) -> RowBatch:
    first = parts[0]
    blocks: dict[Any, Any] = {kind: np.concatenate([p.blocks[kind] for p in parts]) for kind in first.blocks}
    times = np.concatenate([p.times for p in parts]), np.concatenate([p.step_times for p in parts])
    return RowBatch(first.group, first.first, first.every, blocks, *times)
