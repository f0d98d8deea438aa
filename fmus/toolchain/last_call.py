"""The function of an FMU that is called: noted where another process can read it when this one has died in it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Final

LONGEST_NAME: Final = 64
"""[byte] The size of the place for the name."""
_places: list[memoryview] = []


def note_calls(place: memoryview) -> None:
    """From now on, note each call in some shared memory of `LONGEST_NAME` bytes."""
    _places[:] = [place]


def noted(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, which notes its name first where that is wanted."""
    if not _places:
        return function
    (place,), text = _places, _text(name)

    def call(*arguments: Any) -> Any:
        place[:] = text
        return function(*arguments)

    call.__name__ = name
    return call


def note(name: str) -> None:
    """Note a call once more that others have followed: what is told is about it."""
    for place in _places:
        place[:] = _text(name)


def _text(name: str) -> bytes:
    return name.encode()[:LONGEST_NAME].ljust(LONGEST_NAME, b"\0")


def name_of(call: object) -> str:
    """The name of the function of FMI that is called; empty if it cannot be told."""
    name = str(getattr(call.func if isinstance(call, partial) else call, "__name__", ""))
    return name[name.find("fmi") :] if "fmi" in name else ""


def last_call(place: memoryview) -> str:
    """The name of the function that was called last; empty where none was, or what stands there is no name."""
    name = bytes(place).rstrip(b"\0").decode("ascii", "replace")
    return name if name.isidentifier() else ""
