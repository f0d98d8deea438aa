"""A loaded library, whose functions of FMI are found whatever stands before their names, and may be absent."""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import inspect
import types
from collections.abc import Callable, Collection
from ctypes import CDLL
from functools import cache
from typing import Any, Final, get_args

from fmus.toolchain.last_call import noted

_WARNING: Final = 1
_ERROR: Final = 3
"""Numbers of FMI for the status of a call."""


class FunctionLibrary(CDLL):
    """A library that is loaded.

    Args:
        library: The library.
        prefix: What stands before the names of its functions.
        failure: The error of a call, by the name of the function and the FMI status.
    """

    def __init__(self, library: CDLL, prefix: str, failure: Callable[[str, int], Exception]) -> None:
        super().__init__(library._name, handle=library._handle)  # noqa: SLF001 - ctypes has no public name for them
        self._prefix = prefix
        self.failure = failure
        self.warned: Callable[[str], None] = lambda _: None
        """Called with the name of a function that returned a warning."""
        self._prepared: dict[tuple[str, tuple[Any, ...]], Any] = {}

    def prepared(self, name: str, arguments: tuple[Any, ...]) -> Any:
        """A function by its name in FMI that takes these types and returns a status, which is left to the caller."""
        key = name, arguments
        if key not in self._prepared:
            function = self[name]  # indexing gives a new object each time, which FMPy does not know
            function.argtypes, function.restype = arguments, ctypes.c_int
            self._prepared[key] = noted(name, function)
        return self._prepared[key]

    def __getattr__(self, name: str) -> Any:
        """A function for FMPy: its calls are noted, and its status is looked at."""
        if name.startswith("__"):
            raise AttributeError(name)
        return _CheckedFunction(name, self[name], self)

    def __getitem__(self, name: Any) -> Any:
        """A function by its name in FMI; one that is absent can be looked up, but not be called."""
        for candidate in (f"{self._prefix}{name}", name):
            try:
                return super().__getitem__(candidate)
            except AttributeError:
                pass
        return _AbsentFunction(self.failure(name, _ERROR))


class BoundFunctions(dict[str, Any]):
    """The functions of a library by FMPy's names for them, each looked up when it is first called.

    FMPy looks up all of them beforehand, and inspects each of its methods for every instance.

    Args:
        library: The library.
        described: FMPy's class of the FMU: the annotations of its methods tell the types of the functions.
    """

    def __init__(self, library: FunctionLibrary, described: type) -> None:
        super().__init__()
        self._library, self._described = library, described

    def __missing__(self, name: str) -> Any:
        # FMPy calls the functions of FMI 1.0 `fmi1...`, where the standard has `fmi...`
        function = self[name] = getattr(self._library, name.replace("fmi1", "fmi", 1))
        function.argtypes, function.restype = _types(self._described, name)
        return function


@cache
def _types(described: type, name: str) -> tuple[list[Any], Any]:
    """The types of the arguments and of the result that a method of FMPy's declares; of alternatives the first."""
    signature = inspect.signature(getattr(described, name))
    declared = [parameter.annotation for parameter in signature.parameters.values()][1:]  # without `self`
    arguments = [get_args(kind)[0] if isinstance(kind, types.UnionType) else kind for kind in declared]
    result = signature.return_annotation
    return arguments, {bytes: ctypes.c_char_p, int: ctypes.c_int}.get(result, result)


class _AbsentFunction:
    """A function that a library lacks. FMPy notes types at it, as at any other function."""

    def __init__(self, error: Exception) -> None:
        self._error = error

    def __call__(self, *_: Any) -> Any:
        raise self._error


class _CheckedFunction:
    """A function of which FMPy notes the types, and checks only whether its status is larger than that of a warning."""

    restype: Any = None
    argtypes: Any = ()

    def __init__(self, name: str, function: Any, library: FunctionLibrary) -> None:
        self._name, self._function, self._library = name, function, library
        self._call = noted(name, function)

    def __setattr__(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)
        if name in {"restype", "argtypes"}:
            setattr(self._function, name, value)

    def __call__(self, *arguments: Any) -> Any:
        result = self._call(*arguments)
        if self.restype is ctypes.c_int:
            if result == _WARNING:
                self._library.warned(self._name)
            elif result < 0:
                raise self._library.failure(self._name, result)
        return result


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
