"""FMI 2.0's log messages, which are a format with any number of values: formatted in C, and passed to their unit.

FMPy's library for this has one receiver only; the one registered here serves all units. The library is loaded once
more, from a copy: a simulation with FMPy in the same process would replace the receiver in the library that FMPy uses.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import itertools
import shutil
from collections.abc import Callable
from functools import cache
from typing import Any

from fmus.toolchain.fmpy_library import FMI2_LOGGING_LIBRARY, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmus.toolchain.scratch import scratch_folder

_receivers: dict[int, tuple[str, Callable[[int, bytes], None]]] = {}
_keys = itertools.count(1)


def register(name: str, receive: Callable[[int, bytes], None]) -> int:
    """Register an instance.

    Args:
        name: Name of the instance, for FMUs that do not pass their environment on.
        receive: Called with the status and the text of each message.

    Returns:
        The environment that the instance has to be given.
    """
    key = next(_keys)
    _receivers[key] = name, receive
    return key


def release(key: int) -> None:
    """Remove an instance that was registered, by its environment."""
    _receivers.pop(key, None)


@cache
def formatting_logger() -> Any:
    """The logger for FMI 2.0's callbacks, the same for all instances."""
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(_logged)
    _kept.append(callbacks.logger)
    library = _own_library()
    if library is not None:
        library.addLoggerProxy(ctypes.byref(callbacks))
    return callbacks.logger


def _own_library() -> ctypes.CDLL | None:
    """A private copy of FMPy's library that formats messages; not every platform has one."""
    with scratch_folder("logger") as folder:
        try:
            library = ctypes.CDLL(shutil.copy(FMI2_LOGGING_LIBRARY, folder))
        except OSError:
            return None
    library.addLoggerProxy.argtypes, library.addLoggerProxy.restype = [ctypes.c_void_p], None
    return library


_kept: list[Any] = []


def _logged(environment: int | None, name: bytes | None, status: int, _category: bytes, message: bytes | None) -> None:
    known = _receivers.get(environment or 0)
    if known is None:  # an FMU that does not pass its environment on is known by its name
        same = [r for n, r in _receivers.values() if n.encode() == name]
        known = ("", same[-1]) if same else None
    if known is not None:
        known[1](status, message or b"")
