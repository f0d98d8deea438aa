"""A child process that runs a module of this project: started, queried with a deadline, and ended in any case.

Messages are pickled Python objects, one after the other. Requests go to the standard input of the child, answers come
from its standard output. In the child, `ParentProcess` reserves both streams for the messages and moves them to other
descriptors; what a library prints goes to standard error. Answers are sealed (`fmus.toolchain.sealed_messages`), so
that what a library writes to descriptors that are not its own is never taken for an answer.
"""

from __future__ import annotations

import math
import os
import pickle
import secrets
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import IO, Any, Final

from fmus.toolchain.scratch import SCRATCH, scratch_root
from fmus.toolchain.sealed_messages import ReadPipe, Seal, SealedMessages, SelectedPipe

_DIES_WITHIN: Final = 5.0
"""[s] The time within which a process that has closed its streams must have ended."""
_SLICE: Final = 0.1
"""[s] The time after which it is looked again whether the child is alive."""
_SECRET: Final = 32
"""The bytes that seal the answers."""
_SEAL: Final = "MACROSTEP_SEAL"
"""The environment variable that the child learns them from, and removes."""
_DESCRIPTORS: Final = (128, 100)
"""The lowest descriptor that the streams of a child are moved to, and from how many one is chosen."""
_SELECTS: Final = os.name == "posix"
"""Whether the system can wait for a pipe; elsewhere a thread reads it."""


@dataclass(frozen=True)
class Death:
    """How a process ended."""

    code: int
    """The exit code, or the negative number of the signal that ended the process."""

    @property
    def signal(self) -> signal.Signals | None:
        """The signal that ended the process, if one did."""
        return signal.Signals(-self.code) if self.code < 0 else None


def death_in_words(death: Death | None) -> str:
    """How a process ended that was to answer: the signal or the exit code; None is one that is still alive."""
    if death is None:
        return "it closed the pipe"
    return death.signal.name if death.signal else f"exit code {death.code}"


class ChildDiedError(RuntimeError):
    """The child process ended, or closed its streams, before it answered.

    Args:
        death: How the process ended; None for one that is still alive.
    """

    def __init__(self, death: Death | None) -> None:
        self.death = death
        super().__init__("the child process ended before it answered")


class ChildSilentError(RuntimeError):
    """The child process did not answer in time and was ended.

    Args:
        within: The time that it had [s].
    """

    def __init__(self, within: float) -> None:
        self.within = within
        super().__init__(f"the child process did not answer within {within:g} s")


class ChildProcess:
    """A running child process; `close` has to be called at the end.

    The child is in a session of its own: Ctrl-C in the terminal reaches only this process, which ends the child in an
    orderly way. Python files in the working folder are not among the modules that the child imports.

    Args:
        module: Name of the module that the child runs with `python -m`; it uses `ParentProcess`.
        environment: Environment variables that differ from those of this process.
        errors: The file that standard error is written to; that of this process where none is given.
    """

    def __init__(
        self, module: str, environment: Mapping[str, str] | None = None, errors: IO[bytes] | None = None
    ) -> None:
        seal = Seal(secrets.token_bytes(_SECRET))
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
            [sys.executable, "-P", "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env={**os.environ, SCRATCH: str(scratch_root()), **(environment or {}), _SEAL: seal.secret.hex()},
            start_new_session=True,
        )
        self.requests = _there(self._process.stdin)
        """The stream that the child reads requests from."""
        answers = _there(self._process.stdout)
        self._answers = SealedMessages(SelectedPipe(answers) if _SELECTS else ReadPipe(answers), seal)

    def ask(self, request: object, within: float | None = None) -> Any:
        """Send a request and wait for its answer, as `answer` does."""
        self.send(request)
        return self.answer(within)

    def send(self, request: object) -> None:
        """Send a request without waiting for its answer. Raises `ChildDiedError`."""
        try:
            pickle.dump(request, self.requests, pickle.HIGHEST_PROTOCOL)
            self.requests.flush()
        except OSError as error:
            raise ChildDiedError(self.death(_DIES_WITHIN)) from error

    def answer(self, within: float | None = None) -> Any:
        """Wait for the next answer.

        Args:
            within: Deadline [s] for the whole answer; without one, this waits as long as the child lives.

        Raises:
            ChildDiedError: The child ended before it answered.
            ChildSilentError: The child did not answer in time; it has been ended, as its late answer would be taken
                for that to the next request.
        """
        deadline = math.inf if within is None else time.monotonic() + within
        try:
            while (message := self._next(min(_SLICE, max(0.0, deadline - time.monotonic())))) is None:
                if time.monotonic() >= deadline:
                    self.kill()
                    raise ChildSilentError(within or 0.0)
            return pickle.loads(message)  # noqa: S301 - from our own process
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            raise ChildDiedError(self.death(_DIES_WITHIN)) from error

    def _next(self, within: float) -> bytes | None:
        """The next answer if it comes within that time [s]. Raises `EOFError` where none can come any more."""
        message = self._answers.next(within)
        # Processes that the child has started may keep its streams open after its end.
        if message is None and not self.is_alive and (message := self._answers.next(within)) is None:
            raise EOFError
        return message

    def death(self, within: float | None = None) -> Death | None:
        """Wait until the child has ended.

        Args:
            within: Deadline [s]; without one, this waits as long as the child lives.

        Returns:
            How it ended; None if it is still alive.
        """
        try:
            return Death(self._process.wait(within))
        except subprocess.TimeoutExpired:
            return None

    @property
    def is_alive(self) -> bool:
        """Whether the child has not ended yet."""
        return self._process.poll() is None

    def kill(self) -> None:
        """End the child at once, and what it has started; this may be called after its end, too."""
        if hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):  # nothing is left of its group
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()

    def close(self) -> None:
        """Wait for the end of the child, and release what belongs to it here. May be called more than once."""
        self._process.wait()
        for stream in (self.requests, self._answers):
            with suppress(OSError):  # nothing receives what has not been sent yet
                stream.close()


class ParentProcess:
    """The other end of a `ChildProcess`, in the child: a stream of requests, and one for answers."""

    def __init__(self) -> None:
        self.requests: IO[bytes] = os.fdopen(moved(0), "rb")
        self._answers = os.fdopen(moved(1), "wb")
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)
        self._seal = Seal(bytes.fromhex(os.environ.pop(_SEAL, "")))

    def request(self) -> Any:
        """Wait for the next request. Raises `EOFError` when there will be none, because the parent has ended."""
        _block(self.requests)
        try:
            return pickle.load(self.requests)  # noqa: S301 - from the process that started this one
        except (OSError, pickle.UnpicklingError) as error:  # a library has closed the stream, or has read from it
            raise EOFError from error

    def answer(self, message: object) -> None:
        """Send one answer. Raises `EOFError` when nobody can receive it, because the parent has ended."""
        try:
            _block(self._answers)
            self._answers.write(self._seal.sealed(pickle.dumps(message, pickle.HIGHEST_PROTOCOL)))
            self._answers.flush()
        except OSError as error:
            raise EOFError from error

    def end_with_parent(self) -> None:
        """End this process as soon as the parent has ended or has closed the requests, whatever goes on here."""
        end_when_closed(self.requests.fileno())


def end_when_closed(descriptor: int) -> None:
    """End this process as soon as the other end of a pipe is closed, which its process does by its own end."""

    def wait() -> None:
        poll = select.poll()
        poll.register(descriptor, 0)  # only that the other end has been closed
        poll.poll()
        os._exit(1)

    if _SELECTS:
        threading.Thread(target=wait, daemon=True).start()


def _block(stream: IO[bytes]) -> None:
    """Make a stream wait again: a library may have changed that."""
    if _SELECTS:
        os.set_blocking(stream.fileno(), True)


def moved(descriptor: int) -> int:
    """The same file at a descriptor that nobody can guess."""
    lowest, number = _DESCRIPTORS
    try:
        import fcntl  # noqa: PLC0415 - only POSIX has it
    except ImportError:
        return os.dup(descriptor)
    return fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, lowest + secrets.randbelow(number))


def _there(stream: IO[bytes] | None) -> IO[bytes]:
    if stream is None:
        raise TypeError("a process without its streams")
    return stream
