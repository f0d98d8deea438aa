"""The messages that a unit has logged: the last of them, each of a length that a person reads."""

from __future__ import annotations

from collections import deque
from typing import Final

from typing_extensions import override

MOST_MESSAGES: Final = 20
"""How many messages are kept; an FMU may log without end."""
LONGEST_MESSAGE: Final = 400
"""[characters] What is kept of one message."""


class MessageLog(deque[str]):
    """The last messages, oldest first."""

    def __init__(self) -> None:
        super().__init__(maxlen=MOST_MESSAGES)
        self.dropped = 0
        """How many older messages are not kept."""

    @override
    def append(self, message: str, /) -> None:
        self.dropped += len(self) == MOST_MESSAGES
        super().append(message if len(message) <= LONGEST_MESSAGE else f"{message[:LONGEST_MESSAGE]} ...")

    @override
    def clear(self) -> None:
        self.dropped = 0
        super().clear()

    def said(self) -> list[str]:
        """The messages for a person: those that repeat each other only once, and how many there were before."""
        kept = list(dict.fromkeys(self))
        return [f"({self.dropped} earlier messages are left out)", *kept] if self.dropped else kept
