"""The recording process, seen from the process that steps.

The stepping process hands rows over in a thread that sleeps most of the time: a step costs the same with a recording
and without one, whatever Rerun and a viewer do. The recording process gets ready while the run is prepared.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING, Final, Self

from fmus.toolchain.child_death import ChildDiedError, Death
from fmus.toolchain.child_process import ChildProcess
from orchestrator.recording.messages import NewRows, RecordingRequest, send

if TYPE_CHECKING:  # slow to import, and only the names are needed
    from orchestrator.stepping.master import Simulation
    from orchestrator.stepping.rows import RowLog

TO_FILE: Final = 0.5
"""[s] Wall time between two batches for a file, which is what a run loses at most when both processes are killed."""
TO_VIEWER: Final = 0.1
"""[s] Wall time between two batches for a viewer, short enough for smooth motion."""
_MOST: Final = 6000
"""The most ticks whose rows are in one message."""
_OPEN_WITHIN: Final = 60.0
"""[s] The time after which the run begins although nothing is open yet."""
_WRITES_WITHIN, _WRITES_A_TICK_WITHIN = 60.0, 0.002
"""[s] The time for writing after the last row, and more for each tick, before the process is assumed to hang."""
LEAST_ROOM: Final = 2**20
"""[byte] With less on the disk, a recording that does not grow has no room."""
_LOOKS_EVERY, _ROOM_WITHIN = 0.5, 5.0
"""[s] When it is looked whether there is room, and the time after which a recording without it never grows."""
_CUT_SHORT_WITHIN: Final = 60.0
"""[s] The time for writing where the run was cut short."""


class RecordingProcess:
    """A process that records; to be used in a `with` statement. No fault of that process reaches the run.

    Args:
        interval: Wall time between two batches of rows [s].
    """

    def __init__(self, interval: float = TO_FILE) -> None:
        self._interval = interval
        self._end: dict[str, str] | None = None
        self._open, self._wake = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self._log: RowLog | None = None
        self._sink: Path | str = ""
        self._failed = ""

    def __enter__(self) -> Self:
        self._said = tempfile.TemporaryFile()
        self._child = ChildProcess("orchestrator.recording.worker", str, errors=self._said, outlives=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._thread is None:
            self._child.kill()  # nothing was begun
        else:
            self.end({})  # cut short, if it was not said before that it has ended
            self.wait(_CUT_SHORT_WITHIN)
        self._child.close()
        self._said.close()

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Record a simulation from now on, until `end`; returns at once."""
        self._log, self._sink = simulation.log, request.sink
        self._thread = threading.Thread(target=self._feed, args=(request, simulation), daemon=True)
        self._thread.start()

    def wait_until_open(self) -> None:
        """Wait until rows are written as they come, or will never be."""
        self._open.wait(_OPEN_WITHIN)

    def end(self, about: Mapping[str, str]) -> None:
        """Announce that there will be no more rows; returns at once.

        Args:
            about: What is known of the run at its end.
        """
        if self._end is None:
            self._end = dict(about)
            self._wake.set()

    def wait(self, timeout: float | None = None) -> str:
        """Wait until everything is written; a process that takes longer is ended.

        Args:
            timeout: The time that it may take [s]; by default a minute, and more for many rows.

        Returns:
            What went wrong, in a line, or nothing.
        """
        if self._thread is None or self._log is None:
            return ""
        if timeout is None:
            timeout = _WRITES_WITHIN + _WRITES_A_TICK_WITHIN * self._log.kept
        try:
            death, why = self._awaited(timeout)
            if death is None:
                self._child.kill()
                self._child.death()
                return why
        finally:
            self._thread.join(1)
        if not death.code:
            return self._failed
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"exit code {death.code}"

    def _awaited(self, timeout: float) -> tuple[Death | None, str]:
        """Wait for the end of the process; what it waits for itself where that does not come."""
        deadline, roomy = time.monotonic() + timeout, time.monotonic()
        while (left := deadline - time.monotonic()) > 0:
            if (death := self._child.death(min(_LOOKS_EVERY, left))) is not None:
                return death, ""
            if _has_room(self._sink):
                roomy = time.monotonic()
            elif time.monotonic() - roomy > _ROOM_WITHIN:  # Rerun waits for ever
                return None, "there is no room on the disk"
        return self._child.death(0), f"not finished within {timeout:g} s"

    def _feed(self, request: RecordingRequest, simulation: Simulation) -> None:
        try:
            self._hand_over(request, simulation)
        except (OSError, ChildDiedError):
            pass  # `wait` says how the process ended
        except Exception as error:  # noqa: BLE001 - the run goes on, and `wait` says what happened
            self._failed = f"{type(error).__name__}: {error}"
        finally:
            self._open.set()  # there is nothing to wait for any more
            with contextlib.suppress(OSError):
                self._child.requests.close()

    def _hand_over(self, request: RecordingRequest, simulation: Simulation) -> None:
        sent, log, stream = 0, simulation.log, self._child.requests
        send(stream, request)
        self._child.answer()
        self._open.set()
        while self._end is None:
            self._wake.wait(self._interval)
            if self._end is None and log.kept > sent:
                sent = self._send_rows(stream, simulation, sent)
        self._send_rows(stream, simulation, sent)

    def _send_rows(self, stream: IO[bytes], simulation: Simulation, first: int) -> int:
        """Send the rows from a tick on, in messages that are not too large; return the tick after them."""
        about, last = self._end, simulation.log.kept
        for begin in range(first, max(last, first + 1), _MOST):
            end = min(begin + _MOST, last)
            rows = simulation.log.batches(begin, end, simulation.step_times)
            send(stream, NewRows(rows, about or None if end == last else None))
        return last


def _has_room(sink: Path | str) -> bool:
    """Whether a file can grow."""
    try:
        return isinstance(sink, str) or shutil.disk_usage(sink.parent).free > LEAST_ROOM
    except OSError:  # it has been moved with its folder
        return True


def recorded_by_process(request: RecordingRequest, simulation: Simulation, about: Mapping[str, str]) -> str:
    """Record a run that is over, in a process of its own; return what went wrong, in a line, or nothing."""
    with RecordingProcess() as process:
        process.begin(request, simulation)
        process.wait_until_open()
        process.end(about)
        return process.wait()
