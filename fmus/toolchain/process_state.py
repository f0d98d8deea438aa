"""What belongs to the whole process and a library may change: kept, and put back."""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import locale
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
_STREAMS: Final = (0, 1, 2)
_ACTION: Final = 256
"""[byte] More than the C structure of what a signal does."""
_DEFAULT_ARITHMETIC: Final = -1
"""The address that stands for rounding to nearest without traps in the C library of Linux (`FE_DFL_ENV`)."""
_C: Any = ctypes.CDLL(None) if os.name == "posix" else None


def _arithmetic() -> Any:
    """The function of the C library that sets how numbers are rounded, and which operations are trapped."""
    if not sys.platform.startswith("linux"):
        return None
    try:
        function = ctypes.CDLL("libm.so.6").fesetenv
    except (OSError, AttributeError):
        return None
    function.argtypes = [ctypes.c_ssize_t]
    return function


class ProcessState:
    """The working folder, permissions, locale, signals, streams and arithmetic of this process as they are now.

    On Windows that is the working folder and the locale.
    """

    def __init__(self) -> None:
        self._folder = Path.cwd()
        self._locale = locale.setlocale(locale.LC_ALL)
        self._arithmetic = _arithmetic()
        self._streams: dict[int, tuple[int, os.stat_result]] = {}
        self._actions: dict[signal.Signals, Any] = {}
        if os.name != "posix":
            return
        self._mask = os.umask(0)
        os.umask(self._mask)
        for number in _STREAMS:
            with suppress(OSError):  # it was closed before
                self._streams[number] = os.dup(number), os.fstat(number)
        for number in _SIGNALS:
            self._actions[number] = ctypes.create_string_buffer(_ACTION)
            _C.sigaction(int(number), None, self._actions[number])

    def restore_quickly(self) -> None:
        """Put back what is cheap and matters at once: the arithmetic, and what Ctrl-C does."""
        if self._arithmetic is not None:
            self._arithmetic(_DEFAULT_ARITHMETIC)
        for number, action in self._actions.items():
            _C.sigaction(int(number), action, None)

    def restore(self) -> None:
        """Put everything back."""
        self.restore_quickly()
        with suppress(OSError):  # the folder has been removed
            os.chdir(self._folder)
        if locale.setlocale(locale.LC_ALL) != self._locale:
            locale.setlocale(locale.LC_ALL, self._locale)
        if os.name == "posix":
            os.umask(self._mask)
        for number, (kept, facts) in self._streams.items():
            if not _is(number, facts):
                os.dup2(kept, number)

    def close(self) -> None:
        """Release what was kept."""
        for kept, _ in self._streams.values():
            os.close(kept)
        self._streams = {}


def _is(number: int, facts: os.stat_result) -> bool:
    """Whether a descriptor is open, and the same file as before."""
    try:
        return os.path.samestat(os.fstat(number), facts)
    except OSError:
        return False
