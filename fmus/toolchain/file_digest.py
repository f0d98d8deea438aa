"""The SHA-256 of files; one that has not changed since is not read again."""

from __future__ import annotations

import hashlib
import os
import time
from functools import lru_cache
from pathlib import Path
from typing import Final, TypeAlias

FileFacts: TypeAlias = tuple[int, ...]
"""What tells a file from another one, and from itself after a change."""
_SETTLED: Final = 2.0
"""[s] The age from which on a change of a file shows in its times, however coarse they are."""


def digest_of(path: Path) -> str:
    """The SHA-256 of a file as hexadecimal digits. Raises `OSError`."""
    found = path.stat()
    if time.time() - max(found.st_mtime, found.st_ctime) < _SETTLED:
        return _read(path)
    return _known(path, facts_of(found))


def facts_of(found: os.stat_result) -> FileFacts:
    """What `os.stat` tells of a file, without the time at which it was read."""
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


@lru_cache(maxsize=256)
def _known(path: Path, _facts: FileFacts) -> str:
    return _read(path)


def _read(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
