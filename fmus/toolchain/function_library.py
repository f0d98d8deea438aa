"""A loaded library, whose functions of FMI are found whatever stands before their names, and may be absent."""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Collection
from ctypes import CDLL
from typing import Any


class FunctionLibrary(CDLL):
    """A library that is loaded.

    Args:
        library: The library.
        prefix: What stands before the names of its functions.
        absent: The error of a call of a function that it lacks, by the name of the function.
        own_prefix: What FMPy puts before the names that it looks up.
    """

    def __init__(self, library: CDLL, prefix: str, absent: Callable[[str], Exception], own_prefix: str = "") -> None:
        super().__init__(library._name, handle=library._handle)  # noqa: SLF001 - ctypes has no public name for them
        self._prefix, self._absent, self._own_prefix = prefix, absent, own_prefix

    def __getitem__(self, name: Any) -> Any:
        """A function by its name in FMI; one that is absent can be looked up, but not be called."""
        name = name.removeprefix(self._own_prefix)
        for candidate in (f"{self._prefix}{name}", name):
            try:
                return super().__getitem__(candidate)
            except AttributeError:
                pass
        return _AbsentFunction(self._absent(name))


class _AbsentFunction:
    """A function that a library lacks. FMPy notes types at it, as at any other function."""

    def __init__(self, error: Exception) -> None:
        self._error = error

    def __call__(self, *_: Any) -> Any:
        raise self._error


def function_prefix(offered: Collection[str], identifier: str, known: str) -> str:
    """What stands before the names of the functions of a library.

    FMI allows a prefix in sources, where usually the model identifier is used; some makers use another one.

    Args:
        offered: The names of the functions that the library offers.
        identifier: The model identifier.
        known: The name of a function that every library offers.
    """
    if known in offered:
        return ""
    others = sorted(name.removesuffix(known) for name in offered if name.endswith(known))
    return next((p for p in (f"{identifier}_", *others) if f"{p}{known}" in offered), "")
