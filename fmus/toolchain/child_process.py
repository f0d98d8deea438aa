"""A child process that runs a module of this project: started, queried with a deadline, and ended in any case.

Requests go to the standard input of the child, answers come from its standard output. In the child, `ParentProcess`
reserves both streams for the messages and moves them to other descriptors; what a library prints goes to standard
error. Requests are pickled, because the child trusts its parent; answers carry values only, of one type
(`fmus.toolchain.typed_messages`), because the child may run foreign code. They are sealed
(`fmus.toolchain.sealed_messages`), so that what a library writes to descriptors that are not its own is never taken for
an answer. A third process between the two ends all that the child has started (`fmus.toolchain.keeper`).
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
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import IO, Any, Final, Generic, TypeVar

from fmus.toolchain.child_death import ChildDiedError, ChildSilentError, Death
from fmus.toolchain.keeper import FAMILY, end_family
from fmus.toolchain.scratch import SCRATCH, scratch_root
from fmus.toolchain.sealed_messages import ReadPipe, Seal, SealedMessages, SelectedPipe
from fmus.toolchain.typed_messages import UnreadableMessageError, read, written

_DIES_WITHIN: Final = 5.0
"""[s] The time within which a process that has closed its streams must have ended."""
_SLICE: Final = 0.1
"""[s] The time after which it is looked again whether the child is alive."""
_SECRET: Final = 32
"""The bytes that seal the answers."""
_OBEYS: Final = 3.0
"""[s] The time that the process has which is to end the child."""
_DESCRIPTORS: Final = (128, 100)
"""The lowest descriptor that the streams of a child are moved to, and from how many one is chosen."""
_SELECTS: Final = os.name == "posix"
"""Whether the system can wait for a pipe; elsewhere a thread reads it."""
_IS_KEPT: Final = sys.platform == "linux"
"""Whether there is a process between this one and the child."""
_T = TypeVar("_T")


class ChildProcess(Generic[_T]):
    """A running child process; `close` has to be called at the end.

    The child is in a session of its own: Ctrl-C in the terminal reaches only this process, which ends the child in an
    orderly way. Python files in the working folder are not among the modules that the child imports.

    Args:
        module: Name of the module that the child runs with `python -m`; it uses `ParentProcess`.
        answers: The type of its answers.
        environment: Environment variables that differ from those of this process.
        errors: The file that standard error is written to; that of this process where none is given.
        shared: Descriptors of this process that the child has too, under the same numbers.
        outlives: Whether the child goes on when this process has ended.
    """

    def __init__(  # noqa: PLR0913 - what a process is started with
        self,
        module: str,
        answers: type[_T],
        environment: Mapping[str, str] | None = None,
        errors: IO[bytes] | None = None,
        *,
        shared: Sequence[int] = (),
        outlives: bool = False,
    ) -> None:
        self._kind = answers
        seal = Seal(secrets.token_bytes(_SECRET))
        self._family = secrets.token_hex(8)
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
            [sys.executable, "-P", "-m", "fmus.toolchain.keeper", module, *["outlives"] * outlives],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env={**os.environ, SCRATCH: str(scratch_root()), **(environment or {}), FAMILY: self._family},
            start_new_session=True,
            pass_fds=shared,
        )
        self.requests = _there(self._process.stdin)
        """The stream that the child reads requests from."""
        self._write(seal.secret, None)
        pipe = _there(self._process.stdout)
        self._answers = SealedMessages(SelectedPipe(pipe) if _SELECTS else ReadPipe(pipe), seal)

    def ask(self, request: object, within: float | None = None) -> _T:
        """Send a request and wait for its answer, as `answer` does."""
        self.send(request, within)
        return self.answer(within)

    def send(self, request: object, within: float | None = None) -> None:
        """Send a request without waiting for its answer.

        Args:
            request: What the child is asked for.
            within: The time [s] in which the child has to take it.

        Raises:
            ChildDiedError: The child has ended.
            ChildSilentError: The child did not take it in time, and has been ended.
        """
        try:
            self._write(pickle.dumps(request, pickle.HIGHEST_PROTOCOL), within)
        except OSError as error:
            raise ChildDiedError(self.death(_DIES_WITHIN)) from error

    def _write(self, content: bytes, within: float | None) -> None:
        if within is None or not _SELECTS:
            self.requests.write(content)
            self.requests.flush()
            return
        deadline, left, pipe = time.monotonic() + within, memoryview(content), self.requests.fileno()
        os.set_blocking(pipe, False)
        try:
            while left:
                try:
                    left = left[os.write(pipe, left) :]
                except BlockingIOError:
                    select.select([], [pipe], [], _SLICE)
                    if time.monotonic() > deadline:
                        self.kill()
                        raise ChildSilentError(within) from None
        finally:
            os.set_blocking(pipe, True)

    def answer(self, within: float | None = None) -> _T:
        """Wait for the next answer.

        Args:
            within: Deadline [s] for the whole answer; without one, this waits as long as the child lives.

        Raises:
            ChildDiedError: The child ended before it answered.
            ChildSilentError: The child did not answer in time; it has been ended, as its late answer would be taken
                for that to the next request.
            UnreadableMessageError: The answer is of another type; the child has been ended.
        """
        deadline = math.inf if within is None else time.monotonic() + within
        try:
            while (message := self._next(min(_SLICE, max(0.0, deadline - time.monotonic())))) is None:
                if time.monotonic() >= deadline:
                    self.kill()
                    raise ChildSilentError(within or 0.0)
            return read(message, self._kind)
        except (EOFError, OSError) as error:
            raise ChildDiedError(self.death(_DIES_WITHIN)) from error
        except UnreadableMessageError:
            self.kill()
            raise

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
        if self.is_alive and _IS_KEPT:
            self._process.terminate()  # the process between ends the others, and then itself
            self.death(_OBEYS)
        # The number of a process that has been waited for may be that of somebody else's group by now.
        if hasattr(os, "killpg") and self._process.returncode is None:
            with suppress(ProcessLookupError, PermissionError):  # nothing is left of its group
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        if _IS_KEPT and self.death(_OBEYS) == Death(-signal.SIGKILL):  # perhaps before it has ended the others
            end_family(self._family)

    def close(self) -> None:
        """Wait for the end of the child, and release what belongs to it here. May be called more than once."""
        if self.death() == Death(-signal.SIGKILL) and _IS_KEPT:
            end_family(self._family)
        for stream in (self.requests, self._answers):
            with suppress(OSError):  # nothing receives what has not been sent yet
                stream.close()


class ParentProcess:
    """The other end of a `ChildProcess`, in the child: a stream of requests, and one for answers."""

    def __init__(self) -> None:
        self.requests: IO[bytes] = os.fdopen(moved(0), "rb")
        self._seal = Seal(self.requests.read(_SECRET))
        self._answers = os.fdopen(moved(1), "wb")
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)

    def request(self) -> Any:
        """Wait for the next request. Raises `EOFError` when there will be none, because the parent has ended."""
        _block(self.requests)
        try:
            return pickle.load(self.requests)  # noqa: S301 - from the process that started this one
        except (OSError, pickle.UnpicklingError) as error:  # a library has closed the stream, or has read from it
            raise EOFError from error

    def answer(self, message: object) -> None:
        """Send one answer.

        Raises:
            EOFError: Nobody can receive it, because the parent has ended.
            MessageSizeError: It is larger than an answer may be; nothing has been sent.
        """
        sealed = self._seal.sealed(written(message))
        try:
            _block(self._answers)
            self._answers.write(sealed)
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
        import resource  # noqa: PLC0415 - the same
    except ImportError:
        return os.dup(descriptor)
    most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= most < lowest + number:  # a person has limited them
        lowest, number = most // 4, max(1, most // 2)
    return fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, lowest + secrets.randbelow(number))


def _there(stream: IO[bytes] | None) -> IO[bytes]:
    if stream is None:
        raise TypeError("a process without its streams")
    return stream
