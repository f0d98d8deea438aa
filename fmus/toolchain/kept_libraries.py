"""Libraries that were compiled for this machine, kept in the user's cache."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import platformdirs


def kept_library(key: str) -> Path:
    """Where a library is kept once it has been compiled, by a key that says what it was compiled from."""
    return platformdirs.user_cache_path("macrostep") / "compiled" / f"{key}.library"


def keep(library: Path, kept: Path) -> None:
    """Copy a library to where it is kept, under its name only when complete: other processes may read it.

    Raises:
        OSError: The cache cannot be written to.
    """
    kept.parent.mkdir(parents=True, exist_ok=True)
    partial = kept.with_suffix(f".{os.getpid()}")
    shutil.copyfile(library, partial)
    partial.replace(kept)
