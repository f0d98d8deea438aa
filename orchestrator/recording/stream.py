"""A run as a Rerun recording: the shapes of `run_picture` and the layout of `screen`, sent to a file or a viewer.

Only this folder imports `rerun`, whose interface changes often. What stays the same from one tick to the next is sent
once, because the viewer shows the latest value.
"""
# pyright: basic
# rerun's recording stream carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import errno
import os
import shutil
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray
from rerun_bindings import flush_and_cleanup_orphaned_recordings

from orchestrator.pictures import pages
from orchestrator.pictures.run_picture import RunPicture
from orchestrator.pictures.screen import ViewGroup, screen
from orchestrator.pictures.shapes import Page, Shape, Style
from orchestrator.recording.archetypes import send_shapes, send_style
from orchestrator.recording.axes import Extremes
from orchestrator.recording.blueprint import blueprint
from orchestrator.system.experiment import TimeGrid
from orchestrator.system.scene import Scene
from orchestrator.system.system import System

if TYPE_CHECKING:  # pandas is slow to import, and only the name is needed
    import pandas as pd


_LOOKS_AFTER, _WRITES_WITHIN = 1.0, 60.0
"""[s] When it is looked why a file does not grow, and the time after which it never will."""
_LEAST_ROOM: Final = 2**22
"""[byte] With less, a file that does not grow has no room."""


@dataclass(frozen=True)
class ShapeBatch:
    """The shapes of some rows: the tick and the time [s] of each row, `(n,)`, and what is drawn."""

    ticks: NDArray[np.int64]
    times: NDArray[np.float64]
    shapes: Iterable[Shape | Style]


class RerunStream:
    """The recording of one run, in a file or in the viewer at a URL, fed with batches of consecutive rows.

    Scenery and styles are written at once; every batch is sent in columns, one call per entity. The layout comes at the
    end, when the ranges of the axes are known, and by `send_layout` before.

    Args:
        sink: A file, or the URL of a viewer; in memory, as `close` gives it, if None.
        system: The system that runs.
        scene: The scene that it is drawn in; None for a system without one.
        name: What the recording is called in the viewer.
        grid: The communication points of the run.
        about: The run's provenance as it is known at the start.
        recorded: The columns of each group that is recorded at the same ticks; every column at every tick if not
            given.
        recording_id: Streams with the same identifier are one recording to a viewer; a new one if not given.
        followed: Whether the viewer shows the newest row while more come.
    """

    def __init__(  # noqa: PLR0913 - what a recording is made of
        self,
        sink: Path | str | None,
        system: System,
        scene: Scene | None,
        *,
        name: str,
        grid: TimeGrid,
        about: Mapping[str, str],
        recorded: Sequence[Collection[str]] | None = None,
        recording_id: str | None = None,
        followed: bool = False,
    ) -> None:
        self._picture, self._grid = RunPicture(system, scene, recorded=recorded), grid
        self._name, self._last, self._extremes = name, grid.start, Extremes()
        page = Page(entity="/about", text=pages.page(name, about, system))
        styles = [page, *self._picture.styles()]
        self._stream, self._sink = _opened(sink, name, styles, recording_id), sink
        self._followed = followed
        self._memory = self._stream.binary_stream() if sink is None else None

    def log(self, frame: pd.DataFrame | Mapping[str, Any], step_times: NDArray[np.float64] | None) -> None:
        """Send consecutive rows. Signals that are recorded at different ticks come in separate calls.

        Args:
            frame: The column `time` [s], and one column for each signal element.
            step_times: The wall time [s] that the step of each row took, `(n,)`; None where it is not known.
        """
        times = np.asarray(frame["time"], dtype=float)
        if not len(times):
            return
        self._last = max(self._last, float(times[-1]))
        shapes = self._extremes.noted(self._picture.shapes(frame, step_times))
        send_shapes(self._stream, self._grid.ticks(times), times, shapes)

    def send_layout(self) -> None:
        """Send the layout as it is known, because somebody may look at the recording from now on."""
        blueprint(screen([self._picture]), self._extremes.ranges(), followed=self._followed).send(self._stream)

    def flush(self) -> None:
        """Write what has been logged, so that it outlives this process. Raises `OSError` where a file cannot grow."""
        _flush(self._stream, self._sink)

    def close(self, about: Mapping[str, str] | None = None) -> bytes:
        """Write what is left, and the file's footer.

        Args:
            about: The run's provenance as it is known at the end; some of it becomes lines of the log as well, at
                the last row.

        Returns:
            The recording, if it was made in memory.
        """
        if self._picture.system.table is not None:
            times = self._grid.times_until(self._last)
            send_shapes(self._stream, self._grid.ticks(times), times, self._picture.driven(times))
        if about is not None:
            ending = self._picture.ending(about)
            last = np.full(len(ending.texts), self._last)
            send_shapes(self._stream, self._grid.ticks(last), last, [ending] if len(last) else [])
            send_style(self._stream, Page(entity="/about", text=pages.page(self._name, about, self._picture.system)))
        if not isinstance(self._sink, str) and not self._followed:  # whoever looks may have changed the layout by now
            self.send_layout()
        self.flush()
        whole = b"" if self._memory is None else self._memory.read() or b""
        self._stream.disconnect()
        del self._stream  # Rerun keeps two threads for a stream until it is told to look for those that nobody has
        self._memory = None
        flush_and_cleanup_orphaned_recordings()
        return whole


def _flush(stream: rr.RecordingStream, sink: Path | str | None) -> None:
    """Wait until all is written; of a file that cannot grow Rerun says nothing, and would wait for ever."""
    if not isinstance(sink, Path):
        stream.flush()
        return None
    began = time.monotonic()
    while True:
        try:
            return stream.flush(timeout_sec=_LOOKS_AFTER)
        except RuntimeError as error:
            if shutil.disk_usage(sink.parent).free < _LEAST_ROOM:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from error
            if time.monotonic() - began > _WRITES_WITHIN:
                raise OSError(errno.EIO, f"nothing can be written within {_WRITES_WITHIN:g} s") from error


def write(path: Path, name: str, layout: ViewGroup, styles: Iterable[Style], batches: Iterable[ShapeBatch]) -> None:
    """Write a whole recording at once.

    Args:
        path: The file.
        name: What the recording is called in the viewer.
        layout: What stands where on the screen.
        styles: What holds from the start.
        batches: What is drawn of the rows.
    """
    stream, extremes = _opened(path, name, styles), Extremes()
    for batch in batches:
        send_shapes(stream, batch.ticks, batch.times, extremes.noted(batch.shapes))
    blueprint(layout, extremes.ranges()).send(stream)
    _flush(stream, path)
    stream.disconnect()
    del stream  # as in `RerunStream.close`
    flush_and_cleanup_orphaned_recordings()


def _opened(
    sink: Path | str | None, name: str, styles: Iterable[Style], recording_id: str | None = None
) -> rr.RecordingStream:
    """A recording with the styles, which hold from the start."""
    stream = rr.RecordingStream("macrostep", recording_id=recording_id)
    stream.set_log_time_enabled(False)
    if sink is not None:
        stream.set_sinks(rr.GrpcSink(sink) if isinstance(sink, str) else rr.FileSink(str(sink)))
    stream.send_recording_name(name)
    for style in styles:
        send_style(stream, style)
    return stream
