"""FMI 2.0's log messages, which come as a format with any number of values: formatted in C, brought to their unit.

FMPy's library for it knows one receiver, so that one stands here for all units. It is loaded once more, from a copy:
the one that FMPy has loaded forgets us when somebody simulates with FMPy in the same process.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import itertools
import shutil
import tempfile
from collections.abc import Callable
from functools import cache
from typing import Any

from fmus.toolchain.fmpy_library import FMI2_LOGGING_LIBRARY, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

_receivers: dict[int, tuple[str, Callable[[int, bytes], None]]] = {}
_keys = itertools.count(1)


def register(name: str, receive: Callable[[int, bytes], None]) -> int:
    """The environment of an instance: what it logs goes, with its status, to `receive`."""
    key = next(_keys)
    _receivers[key] = name, receive
    return key


def release(key: int) -> None:
    """Forget an instance."""
    _receivers.pop(key, None)


@cache
def formatting_logger() -> Any:
    """The logger for FMI 2.0's callbacks."""
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(_logged)
    _kept.append(callbacks.logger)
    library = _own_library()
    if library is not None:
        library.addLoggerProxy(ctypes.byref(callbacks))
    return callbacks.logger


def _own_library() -> ctypes.CDLL | None:
    """FMPy's library that formats messages, loaded for us alone; there is none for every platform."""
    with tempfile.TemporaryDirectory(prefix="fmi2_logger_", ignore_cleanup_errors=True) as folder:
        try:
            library = ctypes.CDLL(shutil.copy(FMI2_LOGGING_LIBRARY, folder))
        except OSError:
            return None
    library.addLoggerProxy.argtypes, library.addLoggerProxy.restype = [ctypes.c_void_p], None
    return library


_kept: list[Any] = []


def _logged(environment: int | None, name: bytes | None, status: int, _category: bytes, message: bytes | None) -> None:
    known = _receivers.get(environment or 0)
    if known is None:  # an FMU that hands on something else: told by its name
        same = [r for n, r in _receivers.values() if n.encode() == name]
        known = ("", same[-1]) if same else None
    if known is not None:
        known[1](status, message or b"")
