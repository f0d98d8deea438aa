"""The memory that this process uses: its pages, and what its C library has given out and not got back."""

from __future__ import annotations

import ctypes
import mmap
from pathlib import Path
from typing import Any, Final, TypeAlias

Used: TypeAlias = tuple[int, ...]
"""[byte] The memory in use, in each of the ways that the system tells it; no entry where it tells none."""


_TOLD: Final = Path("/proc/self/statm")
_C: Final[Any] = ctypes.CDLL(None) if _TOLD.is_file() else None
"""The C library of this process, on Linux."""


class _HeapFacts(ctypes.Structure):
    """What `mallinfo2` of the GNU C library tells: the bytes in mapped regions and in use are those that count here."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            "arena",
            "ordblks",
            "smblks",
            "hblks",
            "hblkhd",
            "usmblks",
            "fsmblks",
            "uordblks",
            "fordblks",
            "keep",
        )
    )


def used() -> Used:
    """The memory in use: pages that are resident, and bytes that the C library has given out.

    The second tells leaks that fit into memory which the process had freed before.
    """
    found: list[int] = []
    try:
        found.append(int(_TOLD.read_text("ascii").split()[1]) * mmap.PAGESIZE)
    except OSError:  # no Linux
        return ()
    if hasattr(_C, "mallinfo2"):
        function = _C.mallinfo2
        function.restype = _HeapFacts
        facts = function()
        found.append(int(facts.hblkhd) + int(facts.uordblks))
    return tuple(found)


def release_free_memory() -> None:
    """Give memory that was freed back to the system, so that what is taken from now on is seen."""
    if hasattr(_C, "malloc_trim"):
        _C.malloc_trim(0)
