"""The FMUs that were built here, known by their digests, so that no other file can pass for one of them."""

from __future__ import annotations

import os
from collections.abc import Collection
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Final

import fmus
from fmus.toolchain.file_digest import digest_of

STAMP_PATH: Final = "extra/org.macrostep/build.json"
"""The file of an FMU that holds the stamp it was built with."""
_LIST: Final = "built_here.txt"
"""The file in the folder of built FMUs that has the digest of each FMU that was ever built."""


def built_folder() -> Path:
    """The folder of built FMUs: in the checkout, or in the user's cache when macrostep is installed."""
    package = Path(fmus.__file__).parent
    if (package.parent / "pyproject.toml").is_file():
        return package / "built"
    import platformdirs  # noqa: PLC0415 - only an installed macrostep needs it

    return platformdirs.user_cache_path("macrostep") / "built"


def note_build(path: Path) -> None:
    """Note that the FMU at `path` was built here, in whatever folder it lies."""
    line = f"{digest_of(path)}\n".encode()
    listed = built_folder() / _LIST
    with suppress(OSError):  # without the list the FMU is taken for a foreign one, which costs microseconds per step
        listed.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(listed, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        try:
            os.write(file, line)  # whole lines, also where several processes build
        finally:
            os.close(file)


def is_own_build(path: Path, files: Collection[str]) -> bool:
    """Whether an FMU is one that was built here, byte by byte.

    Args:
        path: The FMU.
        files: The paths of the files in it; one without a stamp need not be read.
    """
    if STAMP_PATH not in files:
        return False
    try:
        listed = built_folder() / _LIST
        facts = listed.stat()
        return digest_of(path) in _listed(listed, facts.st_mtime_ns, facts.st_size)
    except OSError:
        return False


@lru_cache(maxsize=1)
def _listed(path: Path, _changed: int, _size: int) -> frozenset[str]:
    return frozenset(path.read_text(encoding="ascii").split())
