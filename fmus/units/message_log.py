"""The messages that a unit has logged: the last of them, each of a length that a person reads."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Final, NamedTuple

from fmus.toolchain.foreign_text import plain
from fmus.toolchain.limits import MOST_MESSAGES, MOST_TOLD

_WARNING, _FAILURE = 1, 3
"""FMI's numbers for the status of a message that is none of a failure, and of one that is."""


class Message(NamedTuple):
    """One message."""

    text: str
    status: int = _FAILURE
    """The FMI status that it was logged with."""

    @property
    def is_of_failure(self) -> bool:
        """Whether it says why something failed."""
        return not 0 <= self.status <= _WARNING


class MessageLog:
    """The last messages, oldest first; those of failures after the others, which never push them out."""

    def __init__(self) -> None:
        self._failures: Final[deque[Message]] = deque(maxlen=MOST_MESSAGES)
        self._others: Final[deque[Message]] = deque(maxlen=MOST_MESSAGES)
        self.dropped = 0
        """How many older messages are not kept."""

    def append(self, text: str | bytes | None, status: int = _FAILURE) -> None:
        """Take a message, as plain text of a limited length."""
        message = Message(plain(text), status)
        kept = self._failures if message.is_of_failure else self._others
        self.dropped += len(kept) == MOST_MESSAGES
        kept.append(message)

    def clear(self) -> None:
        """Forget all messages."""
        self.dropped = 0
        self._failures.clear()
        self._others.clear()

    def __iter__(self) -> Iterator[Message]:
        yield from self._others
        yield from self._failures

    def __len__(self) -> int:
        return len(self._others) + len(self._failures)

    def said(self) -> list[str]:
        """The last messages for a person: those of failures, or the others where there are none.

        Messages that repeat each other are shown once; how many others there were is said too.
        """
        shown = list(dict.fromkeys(message.text for message in self._failures or self._others))[-MOST_TOLD:]
        left_out = self.dropped + sum(message.text not in shown for message in self)
        return [f"({left_out} other messages are left out)", *shown] if left_out else shown
