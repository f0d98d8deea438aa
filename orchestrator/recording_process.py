"""A process of its own that records while the run steps.

The stepping process hands it rows through a pipe, in a thread that sleeps most of the time: a step costs the same with
it and without it, whatever Rerun and a viewer do. It gets ready while the run is prepared. When the rows end without
a word, because the stepping process has died, it completes the recording with what it has.

Messages are pickled, one after the other: what to record, then batches of rows, then what is known in the end.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
import traceback
import uuid
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.abc import MetaPathFinder
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, Final, Protocol, Self, TypeAlias

from typing_extensions import override

if TYPE_CHECKING:  # who starts the process does not wait for what it imports
    from orchestrator.log import Batch, Element
    from orchestrator.master import Simulation

Messages: TypeAlias = "queue.SimpleQueue[bytes | None]"

TO_FILE: Final = 0.5
"""[s] wall time between two batches for a file: what a run may lose that is killed together with this process"""
TO_VIEWER: Final = 0.1
"""[s] the same for a viewer, so that motion looks like motion"""
_OPEN_WITHIN: Final = 60.0
"""[s] until the run begins all the same"""


@dataclass(frozen=True)
class Request:
    """What to record, and where to: a file, or the viewer at a URL."""

    folder: Path
    """The run folder with its `system.ssp`"""
    sink: Path | str
    elements: list[list[Element]]
    """What each group of rows holds"""
    about: dict[str, str]
    """The run's provenance"""
    recording_id: str = field(default_factory=lambda: uuid.uuid4().hex)


@dataclass(frozen=True)
class Rows:
    """Rows that are new; the last ones come with what is known of the run in the end."""

    batches: list[Batch]
    about: dict[str, str] | None = None


class Recorder(Protocol):
    """Who writes the rows of a run to a file or a viewer."""

    def begin(self, request: Request, simulation: Simulation) -> None:
        """Record `simulation` from now on, until `end`."""

    def end(self, about: Mapping[str, str]) -> None:
        """There will be no more rows; comes back at once."""

    def wait_until_open(self) -> None:
        """Wait until rows are written as they come."""

    def wait(self) -> str:
        """Wait until everything is written; what went wrong, in a line, or nothing."""
        ...


class RecordingProcess:
    """The stepping side; use it in a `with` statement. What goes wrong in the process never reaches the run."""

    def __init__(self, interval: float = TO_FILE) -> None:
        self._interval = interval
        self._end: dict[str, str] | None = None
        self._open, self._wake = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> Self:
        self._said = tempfile.TemporaryFile()
        command = [sys.executable, "-m", "orchestrator.recording_process"]
        # a session of its own: Ctrl-C in the terminal is for the run, which then ends this process in order
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, start_new_session=True
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._process.poll() is None and self._thread is None:
            self._process.kill()  # nothing was begun
        elif self._process.poll() is None:
            self.end({})
            self.wait(10)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                _there(pipe).close()
        self._said.close()

    def begin(self, request: Request, simulation: Simulation) -> None:
        """Record `simulation` from now on, until `end`; comes back at once."""
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
        """Wait until everything is written, or end the process; what went wrong, in a line, or nothing."""
        if self._thread is None:
            return ""
        try:
            code = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return f"not finished within {timeout:g} s"
        finally:
            self._thread.join(1)
        if not code:
            return ""
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"exit code {code}"

    def _feed(self, request: Request, simulation: Simulation) -> None:
        stream, sent, log = _there(self._process.stdin), 0, simulation.log
        with contextlib.suppress(OSError):  # the process is gone; `wait` tells why
            _write(stream, request)
            opened = _there(self._process.stdout)
            while opened.readline() not in {b"open\n", b"open\r\n", b""}:  # libraries may say something too
                pass
            self._open.set()
            while self._end is None:
                self._wake.wait(self._interval)
                ended, kept = self._end, log.kept
                if kept > sent and ended is None:
                    _write(stream, Rows(log.batches(sent, kept, simulation.step_times)))
                    sent = kept
            _write(stream, Rows(log.batches(sent, log.kept, simulation.step_times), self._end))
            stream.close()


def _there(pipe: IO[bytes] | None) -> IO[bytes]:
    if pipe is None:
        raise TypeError("a process without its pipes")
    return pipe


def _write(stream: IO[bytes], message: object) -> None:
    """A message is bytes within a pickle, so that who receives it need not understand it."""
    pickle.dump(pickle.dumps(message, pickle.HIGHEST_PROTOCOL), stream, pickle.HIGHEST_PROTOCOL)
    stream.flush()


class _WithoutPandas(MetaPathFinder):
    """Hides pandas, which recording has no need of: pyarrow imports all of it as soon as Rerun hands it a list."""

    @override
    def find_spec(self, fullname: str, path: object, target: object = None) -> None:
        if fullname == "pandas":
            raise ModuleNotFoundError("left out of the process that records", name=fullname)


def main(stream: IO[bytes]) -> None:
    """The recording side: read messages until they end."""
    sys.meta_path.insert(0, _WithoutPandas())
    messages: Messages = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(stream, messages), daemon=True).start()
    _get_ready()
    request: Request | None = _next(messages)
    if request is not None:
        _record(request, messages)


def _receive(stream: IO[bytes], messages: Messages) -> None:
    """Take what comes, so that the other side never waits; nothing more is `None`.

    Nothing is imported here: two threads that import modules that need each other find them half made.
    """
    with contextlib.suppress(EOFError, pickle.UnpicklingError, OSError):
        while True:
            messages.put(pickle.load(stream))  # noqa: S301 - from the process that started this one
    messages.put(None)


def _next(messages: Messages) -> Any:
    """The next message, as soon as there is one."""
    message = messages.get()
    return None if message is None else pickle.loads(message)  # noqa: S301 - from the process that started this one


def _get_ready() -> None:
    for module in ("ssp.reader", "viewing.rerun_stream", "recording"):
        importlib.import_module(f"orchestrator.{module}")


def _record(request: Request, messages: Messages) -> None:
    from orchestrator.recording import Recording, joined  # noqa: PLC0415
    from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415

    scenario = ssp_reader.read(request.folder / "system.ssp")
    recording = Recording(request, scenario)
    print("open", flush=True)  # noqa: T201 - what the other side waits for
    about, over = {**request.about, "status": "cut short"}, False
    while not over:
        found = _waiting(messages)
        over = found[-1] is None
        rows: list[Rows] = [message for message in found if message is not None]
        about = next((part.about for part in rows if part.about is not None), about)
        recording.log(joined([batch for part in rows for batch in part.batches]), last=over)
    recording.close(about)


def _waiting(messages: Messages) -> list[Any]:
    """All messages that have come, at least one; after the last there is `None`."""
    found = [_next(messages)]
    while not messages.empty() and found[-1] is not None:
        found.append(_next(messages))
    return found


if __name__ == "__main__":
    code = 0
    try:
        main(sys.stdin.buffer)
    except Exception:  # noqa: BLE001 - the other side tells
        traceback.print_exc()
        code = 1
    importlib.import_module("orchestrator.ssp.archive").remove_packages()
    # at once: threads still read from the pipe, or hold on to a viewer that hangs; everything is written by now
    sys.stderr.flush()
    os._exit(code)
