"""A number in memory that two processes share: one changes it, the other waits for that, first awake and then asleep.

A process waits awake only while the other one runs on another processor, and leaves its own to any that can use it.
This needs the futex of Linux, and a processor that shows others its writes in order: x86-64.
"""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import mmap
import os
import platform
import sys
from time import perf_counter
from typing import Any, Final

_FUTEX: Final = 202
"""The number of the system call on x86-64."""
_WAIT: Final = 0
_WAKE: Final = 1
_AWAKE: Final = 50e-6
"""[s] The time that a process waits awake: as long as it takes to fall asleep and to be woken."""
_LARGEST: Final = 0xFFFFFFFF


def counters_work() -> bool:
    """Whether this system has what the counters need."""
    return sys.platform == "linux" and platform.machine() == "x86_64"


class _Duration(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


class SharedCounter:
    """A number in shared memory, from 0; after the largest comes 0 again.

    Args:
        memory: The memory, which is 0 at first.
        at: The place of the counter in it [byte], a multiple of 8: the number, and the processor of who changes it.
    """

    def __init__(self, memory: mmap.mmap, at: int) -> None:
        self._numbers = memoryview(memory).cast("I")
        self._index = at // 4
        self._first: Any = ctypes.c_char.from_buffer(memory, at)  # keeps the memory in its place
        address = ctypes.addressof(self._first)
        system = ctypes.CDLL(None)
        self._call, self._processor = system.syscall, system.sched_getcpu
        self._call.argtypes = [ctypes.c_long, ctypes.c_size_t, ctypes.c_int, ctypes.c_uint, ctypes.c_size_t]
        self._wait_arguments = (_FUTEX, address, _WAIT)
        self._wake_arguments = (_FUTEX, address, _WAKE, 1, 0)
        self._duration = _Duration()

    @property
    def value(self) -> int:
        """The number."""
        return self._numbers[self._index]

    def increase(self) -> int:
        """Count one more, and wake the process that waits for it; gives the new number."""
        self._numbers[self._index + 1] = self._processor()
        value = self._numbers[self._index] = (self._numbers[self._index] + 1) & _LARGEST
        self._call(*self._wake_arguments)
        return value

    def is_past(self, value: int, within: float) -> bool:
        """Wait until the number is another one than `value`.

        Args:
            value: The number that it had.
            within: The time after which this gives up [s]; signals end the wait, too.

        Returns:
            Whether it is another one.
        """
        numbers, index = self._numbers, self._index
        if numbers[index] != value:
            return True
        end = perf_counter() + (_AWAKE if numbers[index + 1] != self._processor() else 0.0)
        while numbers[index] == value:
            if perf_counter() >= end:
                self._duration.seconds, self._duration.nanoseconds = int(within), int(within % 1 * 1e9)
                self._call(*self._wait_arguments, value, ctypes.addressof(self._duration))
                return numbers[index] != value
            os.sched_yield()
        return True

    def release(self) -> None:
        """Let go of the memory; nothing may follow."""
        self._numbers.release()
        self._first = None
