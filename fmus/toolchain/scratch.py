"""Temporary folders: all of a process stand in one, which the next process removes if this one was killed."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

SCRATCH: Final = "MACROSTEP_SCRATCH"
"""The environment variable by which a process learns the folder in which its temporary folders stand.

A child process has one of its parent's: then it needs none of its own, and leaves nothing behind when it is killed.
"""
_PREFIX: Final = "macrostep_"
_LOCK: Final = ".lock"
"""The file that a process locks as long as it lives, whatever ends it."""


def scratch_folder(purpose: str) -> tempfile.TemporaryDirectory[str]:
    """A new temporary folder, to be used in a `with` statement.

    Args:
        purpose: What it is for, in a word that its name begins with.

    Returns:
        The folder; it is removed at the end of the statement, and in any case before the end of this process or by the
        next one.
    """
    return tempfile.TemporaryDirectory(prefix=f"{purpose}_", dir=scratch_root(), ignore_cleanup_errors=True)


def scratch_root() -> Path:
    """The folder in which the temporary folders of this process stand."""
    given = os.environ.get(SCRATCH)
    return Path(given) if given is not None else _own(os.getpid(), tempfile.gettempdir())[0]


@lru_cache
def _own(process: int, place: str) -> tuple[Path, Any]:
    """A folder for a process, with its lock; those of processes that do not live any more are removed."""
    from filelock import FileLock  # noqa: PLC0415 - slow to import, and child processes do not need it

    _remove_left_behind(Path(place))
    while True:
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=place)).resolve()
        with suppress(OSError):  # another process has taken it for one that was left behind, and has removed it
            lock = FileLock(folder / _LOCK, thread_local=False)
            lock.acquire()
            if (folder / _LOCK).exists():
                atexit.register(_remove, folder, process)
                return folder, lock


def _remove(folder: Path, process: int) -> None:
    """Remove the folder of this process; one that has been forked from it leaves it alone."""
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def _remove_left_behind(place: Path) -> None:
    """Remove the folders whose processes do not live any more; those of other users cannot be locked."""
    from filelock import FileLock, Timeout  # noqa: PLC0415

    for path in place.glob(f"{_PREFIX}*/{_LOCK}"):
        with suppress(OSError, Timeout), FileLock(path, timeout=0):
            shutil.rmtree(path.parent, ignore_errors=True)
