"""Saved states as bytes: several parts become one, and one becomes several again."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Final

import numpy as np

from fmus.units.unit import Column

_LENGTH: Final = struct.Struct("<Q")


def joined(parts: Sequence[bytes]) -> bytes:
    """The parts as one, each behind its length."""
    return b"".join(_LENGTH.pack(len(part)) + part for part in parts)


def array_of(content: bytes, like: Column) -> Column:
    """The numbers in some bytes, as many and of the same type as those of another array. Raises `ValueError`."""
    values = np.frombuffer(content, like.dtype)
    if values.shape != like.shape:
        raise ValueError(f"{values.size} numbers in place of {like.size}")
    return values


def parted(content: bytes, count: int) -> list[bytes]:
    """The parts again.

    Args:
        content: What `joined` gave.
        count: The number of parts.

    Raises:
        ValueError: The bytes are no such parts.
    """
    parts: list[bytes] = []
    at = 0
    while at + _LENGTH.size <= len(content):
        (length,) = _LENGTH.unpack_from(content, at)
        at += _LENGTH.size
        parts.append(content[at : at + length])
        at += length
    if at != len(content) or len(parts) != count:
        raise ValueError(f"{len(parts)} parts in {len(content)} bytes in place of {count}")
    return parts
