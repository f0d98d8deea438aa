"""Signals that ask a process to end: all act as Ctrl-C does, and all wait where work has to be completed."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Final

ENDING_SIGNALS: Final = tuple(getattr(signal, n) for n in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, n))
"""The signals that ask for an end in an orderly way."""
_ECHO: Final = 1.0
"""[s] A signal that comes so soon after another is the same request, by another way."""


@contextmanager
def interruptible() -> Generator[None]:
    """Let every signal that asks for an end raise `KeyboardInterrupt`; one that is ignored here stays ignored."""
    last = -_ECHO

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        nonlocal last
        before, last = last, time.monotonic()
        if last - before >= _ECHO:
            raise KeyboardInterrupt

    wanted = [number for number in ENDING_SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    with _handled(wanted, interrupt):
        yield


@contextmanager
def without_interrupts() -> Generator[None]:
    """Ignore those signals, so that what has been begun is completed; this should take a few seconds at most."""
    with _handled(ENDING_SIGNALS, signal.SIG_IGN):
        yield


@contextmanager
def _handled(numbers: Any, handler: Any) -> Generator[None]:
    """Handle signals so in the block; only the main thread of a process can do that."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, former in before.items():
            signal.signal(number, former)
