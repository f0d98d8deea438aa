"""How a child process ended, or that it did not answer, as data."""

from __future__ import annotations

import signal
from dataclasses import dataclass


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
