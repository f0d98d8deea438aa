"""A process of its own that records while the run steps.

The stepping process hands it rows through a pipe, in a thread that sleeps most of the time: a step costs the same with
it and without it, whatever Rerun and a viewer do. It gets ready while the run is prepared.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from types import TracebackType
from typing import IO, TYPE_CHECKING, Final, Self

from orchestrator.recording.messages import NewRows, RecordingRequest, send

if TYPE_CHECKING:  # who starts the process does not wait for what it imports
    from orchestrator.stepping.master import Simulation
    from orchestrator.stepping.rows import Log

TO_FILE: Final = 0.5
"""[s] wall time between two batches for a file: what a run may lose that is killed together with this process"""
TO_VIEWER: Final = 0.1
"""[s] the same for a viewer, so that motion looks like motion"""
_OPEN_WITHIN: Final = 60.0
"""[s] until the run begins all the same"""
_WRITES_WITHIN, _WRITES_A_TICK_WITHIN = 60.0, 0.002
"""[s] after the last row, and for each tick, until the process counts as one that hangs"""


class RecordingProcess:
    """The stepping side; use it in a `with` statement. What goes wrong in the process never reaches the run."""

    def __init__(self, interval: float = TO_FILE) -> None:
        self._interval = interval
        self._end: dict[str, str] | None = None
        self._open, self._wake = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self._log: Log | None = None
        self._failed = ""

    def __enter__(self) -> Self:
        self._said = tempfile.TemporaryFile()
        command = [sys.executable, "-m", "orchestrator.recording.worker"]
        # a session of its own: Ctrl-C in the terminal is for the run, which then ends this process in order
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, start_new_session=True
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._thread is None:
            self._process.kill()  # nothing was begun
        else:
            self.end({})  # cut short, if it was not said before that it has ended
            self.wait(10)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                _there(pipe).close()
        self._said.close()

    def begin(self, request: RecordingRequest, simulation: Simulation) -> None:
        """Record `simulation` from now on, until `end`; comes back at once."""
        self._log = simulation.log
        self._thread = threading.Thread(target=self._feed, args=(request, simulation), daemon=True)
        self._thread.start()

    def wait_until_open(self) -> None:
        """Wait until rows are written as they come."""
        self._open.wait(_OPEN_WITHIN)

    def end(self, about: Mapping[str, str]) -> None:
        """There will be no more rows; comes back at once."""
        if self._end is None:
            self._end = dict(about)
            self._wake.set()

    def wait(self, timeout: float | None = None) -> str:
        """Wait until everything is written, or end the process; what went wrong, in a line, or nothing.

        Without a `timeout` [s] a process that hangs has a minute, and more for many rows.
        """
        if self._thread is None or self._log is None:
            return ""
        if timeout is None:
            timeout = _WRITES_WITHIN + _WRITES_A_TICK_WITHIN * self._log.kept
        try:
            code = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return f"not finished within {timeout:g} s"
        finally:
            self._thread.join(1)
        if not code:
            return self._failed
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"exit code {code}"

    def _feed(self, request: RecordingRequest, simulation: Simulation) -> None:
        stream = _there(self._process.stdin)
        try:
            self._hand_on(stream, request, simulation)
        except OSError:
            pass  # the process is gone; `wait` tells why
        except Exception as error:  # noqa: BLE001 - the run goes on, and `wait` tells
            self._failed = f"{type(error).__name__}: {error}"
        finally:
            self._open.set()  # whoever waits for it has nothing to wait for
            with contextlib.suppress(OSError):
                stream.close()

    def _hand_on(self, stream: IO[bytes], request: RecordingRequest, simulation: Simulation) -> None:
        sent, log = 0, simulation.log
        send(stream, request)
        opened = _there(self._process.stdout)
        while opened.readline() not in {b"open\n", b"open\r\n", b""}:  # libraries may say something too
            pass
        self._open.set()
        while self._end is None:
            self._wake.wait(self._interval)
            ended, kept = self._end, log.kept
            if kept > sent and ended is None:
                send(stream, NewRows(log.batches(sent, kept, simulation.step_times)))
                sent = kept
        send(stream, NewRows(log.batches(sent, log.kept, simulation.step_times), self._end or None))


def _there(pipe: IO[bytes] | None) -> IO[bytes]:
    if pipe is None:
        raise TypeError("a process without its pipes")
    return pipe
