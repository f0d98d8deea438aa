"""Messages that are told apart from anything else that is written to the same pipe: each is sealed with a secret."""

from __future__ import annotations

import hashlib
import os
import queue
import struct
import threading
import time
from abc import ABC, abstractmethod
from selectors import EVENT_READ, DefaultSelector
from typing import IO, Final

from typing_extensions import override

from fmus.toolchain.limits import LARGEST_ANSWER

_MARK: Final = 16
_LENGTH: Final = struct.Struct("<Q")
_DIGEST: Final = 16
_AT_ONCE: Final = 1 << 16
"""The bytes that are read at once."""
_FLOOD: Final = 1.0
"""[s] The time after the deadline in which what comes is still read: a message, or something else without end."""


class MessageSizeError(ValueError):
    """A message that is larger than any may be."""


class Seal:
    """What both ends of a pipe know, and nobody else.

    Args:
        secret: Bytes that were chosen at random.
    """

    def __init__(self, secret: bytes) -> None:
        self.secret = secret
        self.mark = hashlib.blake2b(secret, digest_size=_MARK).digest()
        """The bytes that a message begins with."""

    def sealed(self, message: bytes) -> bytes:
        """A message as it is written. Raises `MessageSizeError`."""
        if len(message) > LARGEST_ANSWER:
            raise MessageSizeError(f"a message of {len(message)} bytes, of at most {LARGEST_ANSWER}")
        return self.mark + _LENGTH.pack(len(message)) + self.digest(message) + message

    def digest(self, message: bytes) -> bytes:
        """The digest of a message, which only those who know the secret can compute."""
        return hashlib.blake2b(message, key=self.secret, digest_size=_DIGEST).digest()


class Pipe(ABC):
    """The reading end of a pipe.

    Args:
        stream: The stream that belongs to it.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream

    @abstractmethod
    def read(self, within: float) -> bytes | None:
        """What has been written, as soon as there is something; None if nothing is, within that time [s].

        Raises:
            EOFError: There is nothing more, and nothing can follow.
        """

    def close(self) -> None:
        """Release the stream."""
        self._stream.close()


class SelectedPipe(Pipe):
    """A pipe of a system that can wait for it."""

    def __init__(self, stream: IO[bytes]) -> None:
        super().__init__(stream)
        self._readable = DefaultSelector()  # prepared once: a step of a unit waits for one answer
        self._readable.register(stream, EVENT_READ)

    @override
    def read(self, within: float) -> bytes | None:
        if not self._readable.select(within):
            return None
        data = os.read(self._stream.fileno(), _AT_ONCE)
        if not data:
            raise EOFError
        return data

    @override
    def close(self) -> None:
        self._readable.close()
        super().close()


class ReadPipe(Pipe):
    """A pipe of any system: a thread waits for it."""

    def __init__(self, stream: IO[bytes]) -> None:
        super().__init__(stream)
        self._read: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._follow, daemon=True)
        self._thread.start()

    def _follow(self) -> None:
        data = b"-"
        while data:
            try:
                data = os.read(self._stream.fileno(), _AT_ONCE)
            except (OSError, ValueError):  # it was closed
                data = b""
            self._read.put(data)

    @override
    def read(self, within: float) -> bytes | None:
        try:
            data = self._read.get(timeout=within) if within > 0 else self._read.get_nowait()
        except queue.Empty:
            return None
        if not data:
            self._read.put(data)
            raise EOFError
        return data


class SealedMessages:
    """The messages in what comes through a pipe; anything else is skipped."""

    def __init__(self, pipe: Pipe, seal: Seal) -> None:
        self._pipe, self._seal = pipe, seal
        self._data = bytearray()

    def next(self, within: float) -> bytes | None:
        """The next message; None if it is not complete within that time [s].

        Raises:
            EOFError: There will be no more.
        """
        until = time.monotonic() + within
        while (message := self._complete()) is None:
            data = self._pipe.read(max(0.0, until - time.monotonic()))
            if data is None:
                return None
            self._data += data
            if time.monotonic() > until + _FLOOD:
                return self._complete()
        return message

    def _complete(self) -> bytes | None:
        """Take the first complete message out of the data."""
        head = _MARK + _LENGTH.size + _DIGEST
        while (at := self._data.find(self._seal.mark)) >= 0:
            del self._data[:at]
            if len(self._data) < head:
                return None
            (length,) = _LENGTH.unpack_from(self._data, _MARK)
            if length <= LARGEST_ANSWER and len(self._data) < head + length:
                return None
            if length <= LARGEST_ANSWER and self._is_sealed(message := bytes(self._data[head : head + length])):
                del self._data[: head + length]
                return message
            del self._data[:_MARK]  # something else was written into it
        del self._data[: max(0, len(self._data) - _MARK + 1)]
        return None

    def _is_sealed(self, message: bytes) -> bool:
        """Whether the message at the beginning of the data is what its head announces."""
        digest = self._data[_MARK + _LENGTH.size : _MARK + _LENGTH.size + _DIGEST]
        return bytes(digest) == self._seal.digest(message)

    def close(self) -> None:
        """Release the pipe."""
        self._pipe.close()
