"""Texts and bytes as a library gives them, by address: read as far as they can be, with a word on what is wrong."""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import os
from typing import Any, Final

from fmus.toolchain.limits import LARGEST_BINARY, LARGEST_STRING
from fmus.units.unit import Unit, UnitError

_C: Final[Any] = ctypes.CDLL(None) if os.name == "posix" else ctypes.CDLL("msvcrt")


def _length(address: int, most: int) -> int:
    """The bytes of a text up to its end, or `most`."""
    function = _C.strnlen
    function.argtypes, function.restype = [ctypes.c_size_t, ctypes.c_size_t], ctypes.c_size_t
    return function(address, most)


class GivenValues:
    """The values that the library of one unit gives; the methods raise `UnitError`.

    Args:
        unit: The unit; without one, nothing is said of values that can be read.
        function: The name of the function that gives them.
    """

    def __init__(self, unit: Unit | None, function: str) -> None:
        self._unit, self._gave = unit, f"`{function}` gave"

    def string(self, name: str, address: int | None) -> str:
        """The value of a String variable."""
        if not address:
            self._remark(f"{self._gave} no text for `{name}`, which is taken as an empty one")
            return ""
        n = _length(address, LARGEST_STRING + 1)
        if n > LARGEST_STRING:
            raise self._error(f"{self._gave} a text of more than {LARGEST_STRING} bytes for `{name}`")
        text = ctypes.string_at(address, n)
        try:
            return text.decode("utf-8")
        except UnicodeDecodeError:
            self._remark(f"{self._gave} a text for `{name}` that is not UTF-8; what cannot be read is replaced")
            return text.decode("utf-8", "replace")

    def binary(self, name: str, address: int | None, size: int) -> bytes:
        """The value of a Binary variable."""
        if size > LARGEST_BINARY:
            raise self._error(f"{self._gave} {size} bytes for `{name}`, of at most {LARGEST_BINARY}")
        if size and not address:
            raise self._error(f"{self._gave} no address of the {size} bytes of `{name}`")
        return ctypes.string_at(address, size) if address else b""

    def _remark(self, text: str) -> None:
        if self._unit is not None:
            self._unit.remark(text)

    def _error(self, action: str) -> UnitError:
        return UnitError("" if self._unit is None else self._unit.name, action, ())
