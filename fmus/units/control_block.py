"""The calls of every macro step, exchanged through memory that two processes share instead of through messages.

The parent fills in the request and counts it; the child carries it out, fills in the reply and counts that. What does
not fit into a few numbers goes through a pipe, and the block only says so.
"""

from __future__ import annotations

import mmap
import struct
from enum import IntEnum
from pathlib import Path
from typing import Final, NamedTuple

from fmus.toolchain.last_call import LONGEST_NAME
from fmus.toolchain.shared_counter import SharedCounter

_SIZE: Final = 4096
_REQUESTS, _REPLIES, _REQUEST_AT, _REPLY_AT = 0, 64, 128, 192  # on cache lines of their own
_CALLED_AT: Final = 256
_REQUEST: Final = struct.Struct("=q??6xdd")
_REPLY: Final = struct.Struct("=q?7x")
_IDLE: Final = 60.0
"""[s] The time after which a child that has nothing to do looks up; its length is of no importance."""


class QuickCall(IntEnum):
    """The methods that are called in every macro step: they take the time and the step, and give a status."""

    MESSAGE = 0
    """None of them: the request is a message in the pipe."""
    GET = 1
    STEP = 2
    ACTIVATE = 3
    UPDATE = 4

    @property
    def method(self) -> str:
        """The name that messages use."""
        return self.name.lower()


_CALLS: Final = tuple(QuickCall)
"""The methods by their numbers."""


class QuickRequest(NamedTuple):
    """A request for a call."""

    call: QuickCall
    set_first: bool = False
    """Whether the inputs have changed and have to be set before."""
    get_after: bool = False
    """Whether the outputs are wanted afterwards."""
    t: float = 0.0
    h: float = 0.0


class ControlBlock:
    """The memory of both processes for requests and replies.

    Args:
        file: The shared file; it is made by the process that comes first.
    """

    def __init__(self, file: Path) -> None:
        with file.open("a+b") as opened:
            opened.truncate(_SIZE)
            self._memory = mmap.mmap(opened.fileno(), _SIZE)
        self._requests = SharedCounter(self._memory, _REQUESTS)
        self._replies = SharedCounter(self._memory, _REPLIES)
        self.called = memoryview(self._memory)[_CALLED_AT : _CALLED_AT + LONGEST_NAME]
        """The name of the function of the FMU that the child has called last."""
        self._seen = 0
        """The last request that the child has seen, or the last reply that the parent expects."""

    def request(self, request: QuickRequest) -> None:
        """In the parent: make a request."""
        _REQUEST.pack_into(self._memory, _REQUEST_AT, *request)
        self._seen = self._replies.value
        self._requests.increase()

    def is_answered(self, within: float) -> bool:
        """In the parent: wait for the reply so long at most [s]; give whether it is there."""
        return self._replies.is_past(self._seen, within)

    @property
    def reply(self) -> tuple[int, bool]:
        """In the parent: the status that the call gave, and whether there is a message in the pipe instead."""
        return _REPLY.unpack_from(self._memory, _REPLY_AT)

    def next_request(self) -> QuickRequest:
        """In the child: wait for the next request."""
        while not self._requests.is_past(self._seen, _IDLE):
            pass
        self._seen = (self._seen + 1) & 0xFFFFFFFF
        call, set_first, get_after, t, h = _REQUEST.unpack_from(self._memory, _REQUEST_AT)
        return QuickRequest(_CALLS[call], set_first, get_after, t, h)

    def answer(self, status: int = 0, *, message: bool = False) -> None:
        """In the child: say that the request was carried out.

        Args:
            status: The status that the call gave.
            message: Whether there is a message in the pipe instead.
        """
        _REPLY.pack_into(self._memory, _REPLY_AT, status, message)
        self._replies.increase()

    def close(self) -> None:
        """Release the memory; nothing may follow."""
        self._requests.release()
        self._replies.release()
        self.called.release()
        self._memory.close()
