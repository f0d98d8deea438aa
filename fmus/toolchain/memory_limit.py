"""A limit of the memory of a process that reads what may ask for any amount of it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress


def memory_limit(most: int) -> Callable[[], None]:
    """What a process calls so that it has no more address space; it does nothing where no system call does it.

    It is made before it is called, because little may be done between a fork and the start of another program.

    Args:
        most: The address space [byte]; a lower limit that a person has set stays.
    """
    try:
        import resource  # noqa: PLC0415 - only POSIX has it
    except ImportError:
        return lambda: None
    _, highest = resource.getrlimit(resource.RLIMIT_AS)
    limit = most if highest == resource.RLIM_INFINITY else min(most, highest)

    def set_limit() -> None:
        with suppress(OSError, ValueError):  # macOS has the call, and may refuse it
            resource.setrlimit(resource.RLIMIT_AS, (limit, highest))

    return set_limit


def without_core_files() -> None:
    """Let the end of this process by a signal leave no file with its memory."""
    with suppress(ImportError):
        import resource  # noqa: PLC0415 - only POSIX has it

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
