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

_T = TypeVar("_T")
_ARRAY: Final = 1
"""The number of MessagePack's extension that stands for an array."""
_NUMBERS: Final = "?bBhHiIlLqQfd"
"""The types of arrays that are read, by numpy's characters."""


class UnreadableMessageError(ValueError):
    """A message that is not of the type that is expected."""


def written(message: object) -> bytes:
    """A message as bytes. Raises `TypeError` for one that consists of something else than values."""
    return _ENCODER.encode(message)


def read(content: bytes, kind: type[_T]) -> _T:
    """The message in some bytes. Raises `UnreadableMessageError`."""
    try:
        return cast("_T", _decoder(kind).decode(content))
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise UnreadableMessageError(str(error)) from error


@cache
def _decoder(kind: Any) -> msgspec.msgpack.Decoder[Any]:
    return msgspec.msgpack.Decoder(kind, dec_hook=_expected, ext_hook=_array)


def _values(item: object) -> Any:
    """What stands for an object that msgspec does not know."""
    if isinstance(item, np.generic):
        return cast("Any", item).item()
    if isinstance(item, np.ndarray):
        array = cast("NDArray[Any]", item)
        content = array.ravel().tolist() if array.dtype == object else array.tobytes()
        return msgspec.msgpack.Ext(_ARRAY, _ENCODER.encode((array.dtype.char, array.shape, content)))
    raise TypeError(f"{type(item).__name__} is no value")


def _array(code: int, packed: memoryview) -> NDArray[Any]:
    """The array that `_values` gave."""
    if code != _ARRAY:
        raise ValueError(f"an extension with the number {code}")
    character, shape, content = _PACKED.decode(packed)
    if character == "O" and isinstance(content, list):
        array: NDArray[Any] = np.empty(len(cast("list[Any]", content)), object)
        array[:] = content
        return array.reshape(shape)
    if character not in _NUMBERS or not isinstance(content, bytes):
        raise ValueError(f"an array of type {character}")
    numbers: NDArray[Any] = np.frombuffer(content, character)
    return numbers.reshape(shape).copy()


def _expected(kind: Any, value: Any) -> Any:
    """A value of a type that msgspec does not know."""
    if (get_origin(kind) or kind) is not np.ndarray or not isinstance(value, np.ndarray):
        raise TypeError(f"{type(value).__name__} in place of {kind}")
    return cast("NDArray[Any]", value)


_ENCODER: Final = msgspec.msgpack.Encoder(enc_hook=_values)
_PACKED: Final = msgspec.msgpack.Decoder(tuple[str, tuple[int, ...], Any])
