"""Messages as bytes that carry values only: reading one makes nothing but the type that is expected.

They are MessagePack, written and read by msgspec, with arrays of numbers as their bytes. What comes from a process that
runs foreign code is read by this, never by pickle.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final, TypeVar, cast, get_origin

import msgspec
import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")
_NUMBERS: Final = "?bBhHiIlLqQfd"
"""The types of arrays that are read, by numpy's characters."""


class UnreadableMessageError(ValueError):
    """A message that is not of the type that is expected."""


def written(message: object) -> bytes:
    """A message as bytes. Raises `TypeError` for one that consists of something else than values."""
    return _ENCODER.encode(message)


def read(content: bytes, kind: type[T]) -> T:
    """The message in some bytes. Raises `UnreadableMessageError`."""
    try:
        return cast("T", _decoder(kind).decode(content))
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise UnreadableMessageError(str(error)) from error


@cache
def _decoder(kind: Any) -> msgspec.msgpack.Decoder[Any]:
    return msgspec.msgpack.Decoder(kind, dec_hook=_array)


def _values(item: object) -> Any:
    """What stands for an object that msgspec does not know."""
    if isinstance(item, np.generic):
        return item.item()
    if isinstance(item, np.ndarray):
        array = cast("NDArray[Any]", item)
        if array.dtype == object:
            return ["O", array.shape, array.ravel().tolist()]
        return [array.dtype.char, array.shape, array.tobytes()]
    raise TypeError(f"{type(item).__name__} is no value")


def _array(kind: Any, values: Any) -> Any:
    """The array that `_values` gave."""
    if (get_origin(kind) or kind) is not np.ndarray:
        raise TypeError(f"{kind} is no value")
    character, shape, content = values
    if character == "O":
        array = np.empty(len(content), object)
        array[:] = content
        return array.reshape(shape)
    if character not in _NUMBERS:
        raise ValueError(f"an array of type {character}")
    return np.frombuffer(content, character).reshape(shape).copy()


_ENCODER: Final = msgspec.msgpack.Encoder(enc_hook=_values)
