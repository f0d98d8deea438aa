"""What results of a kind consist of, and the manifest in their folder that says which of it they have written.

A name counts only if it stands in the manifest and results of this kind have it: a manifest that somebody else has
written cannot name other files.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final, cast

MANIFEST_FILE: Final = "manifest.json"
"""Lists the files that the results in a folder consist of."""
_LARGEST: Final = 2**20
"""[byte] A larger file is no manifest."""


@dataclass(frozen=True)
class Contents:
    """What results of a kind consist of."""

    kind: str
    """What they are, for messages."""
    files: tuple[str, ...]
    """Names relative to the folder, in folders of their own at most one deep; `*` stands for any part of a name."""
    inner: tuple[str, ...] = ()
    """Folders inside it, which hold results of their own."""

    @property
    def folders(self) -> set[str]:
        """The folders that the files are in."""
        return {name.partition("/")[0] for name in self.files if "/" in name}


def read_manifest(folder: Path, contents: Contents) -> set[str] | None:
    """What of some contents the manifest of a folder lists; None where there is no manifest of this kind."""
    path = folder / MANIFEST_FILE
    try:
        if path.is_symlink() or path.stat().st_size > _LARGEST:
            return None
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(content, dict) or cast(dict[str, object], content).get("holds") != contents.kind:
        return None
    files = cast(dict[str, object], content).get("files")
    return set(contents.files).intersection(map(str, cast(list[object], files))) if isinstance(files, list) else None


def write_manifest(folder: Path, contents: Contents) -> None:
    """Write which files the results in a folder consist of."""
    text = json.dumps({"holds": contents.kind, "files": sorted(contents.files)}, indent=1)
    with unfinished(folder / MANIFEST_FILE) as file:
        file.write_text(text + "\n", encoding="utf-8")


def present(folder: Path, name: str) -> list[Path]:
    """What is there under a name of `Contents.files`, links that lead nowhere too."""
    inside, _, leaf = name.rpartition("/")
    if (folder / inside).is_symlink():
        return []
    try:
        return [path for path in (folder / inside).iterdir() if fnmatchcase(path.name, leaf)]
    except OSError:
        return []


def remove(folder: Path, contents: Contents, names: Collection[str]) -> None:
    """Remove some of the files that results consist of, and their folders where these are empty then."""
    for name in names:
        for path in present(folder, name):
            path.unlink()
    for name in contents.folders.intersection(name.partition("/")[0] for name in names):
        with suppress(OSError):  # it is not there, or holds other things
            (folder / name).rmdir()


def reason(error: OSError) -> str:
    """What the system says of an error, in words."""
    return os.strerror(error.errno) if error.errno else str(error)


@contextmanager
def unfinished(path: Path) -> Generator[Path]:
    """A file that has its name when it is complete; of a process that is killed or fails, no partial file remains."""
    partial = path.with_name(f".{path.name}")
    try:
        yield partial
        partial.replace(path)
    except BaseException:
        with suppress(OSError):
            partial.unlink()
        raise
