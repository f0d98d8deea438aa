"""A child process that runs a module of this project: started, queried with a deadline, and ended in any case.

Messages are pickled Python objects, one after the other. Requests go to the standard input of the child, answers come
from its standard output. In the child, `ParentProcess` reserves both streams for the messages: what a library
prints goes to standard error, so that it is never taken for an answer.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from selectors import EVENT_READ, DefaultSelector
from typing import IO, Any, Final

_DIES_WITHIN: Final = 5.0
"""[s] The time within which a process that has closed its streams must have ended."""


@dataclass(frozen=True)
class Death:
    """How a process ended."""

    code: int
    """The exit code, or the negative number of the signal that ended the process."""

    @property
    def signal(self) -> signal.Signals | None:
        """The signal that ended the process, if one did."""
        return signal.Signals(-self.code) if self.code < 0 else None


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
    orderly way.

    Args:
        module: Name of the module that the child runs with `python -m`; it uses `ParentProcess`.
        environment: Environment variables that differ from those of this process.
        errors: The file that standard error is written to; that of this process where none is given.
    """

    def __init__(
        self, module: str, environment: Mapping[str, str] | None = None, errors: IO[bytes] | None = None
    ) -> None:
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env={**os.environ, **(environment or {})},
            start_new_session=True,
        )
        self.requests = _there(self._process.stdin)
        """The stream that the child reads requests from."""
        self._answers = _there(self._process.stdout)
        self._readable = DefaultSelector()  # prepared once: a step of a unit waits for one answer
        self._readable.register(self._answers, EVENT_READ)

    def ask(self, request: object, within: float | None = None) -> Any:
        """Send a request and wait for its answer, as `answer` does."""
        try:
            pickle.dump(request, self.requests, pickle.HIGHEST_PROTOCOL)
            self.requests.flush()
        except OSError as error:
            raise ChildDiedError(self.death(_DIES_WITHIN)) from error
        return self.answer(within)

    def answer(self, within: float | None = None) -> Any:
        """Wait for the next answer.

        Args:
            within: Deadline [s]; without one, this waits as long as the child lives.

        Raises:
            ChildDiedError: The child ended before it answered.
            ChildSilentError: The child did not answer in time; it has been ended, as its late answer would be taken
                for that to the next request.
        """
        try:
            if within is not None and not self._readable.select(within):
                self.kill()
                raise ChildSilentError(within)
            return pickle.load(self._answers)  # noqa: S301 - from our own process
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            raise ChildDiedError(self.death(_DIES_WITHIN)) from error

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
        self._readable.close()
        for stream in (self.requests, self._answers):
            with suppress(OSError):  # nothing receives what has not been sent yet
                stream.close()


class ParentProcess:
    """The other end of a `ChildProcess`, in the child: a stream of requests, and one for answers."""

    def __init__(self) -> None:
        self.requests: IO[bytes] = os.fdopen(os.dup(0), "rb")
        self._answers = os.fdopen(os.dup(1), "wb")
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)

    def answer(self, message: object) -> None:
        """Send one answer."""
        pickle.dump(message, self._answers, pickle.HIGHEST_PROTOCOL)
        self._answers.flush()


def _there(stream: IO[bytes] | None) -> IO[bytes]:
    if stream is None:
        raise TypeError("a process without its streams")
    return stream
