"""A folder for results that belongs to one process while it is written, and what of former results is removed from it.

The folder is locked, and its manifest lists what may be written to it. Only files that stand in the manifest of former
results, and have a name that results of this kind have, are ever removed; anything else stays, or the request is
refused where it would be in the way.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from filelock import FileLock, Timeout

from components.interfaces.problem import Problem, RequestError, listed, raise_if_any, refuse
from orchestrator.results.manifest import (
    MANIFEST_FILE,
    Contents,
    present,
    read_manifest,
    reason,
    remove,
    write_manifest,
)

LOCK: Final = ".lock"
"""Locked while the folder is written; it holds the number of the process."""
_LISTED: Final = 8
"""The files that a message lists."""


class ClaimedFolder:
    """A folder that this process alone writes to; to be used in a `with` statement, or released.

    Args:
        path: The folder, an absolute path.
        named: The folder as a person named it.
        contents: What is written to it.
        lock: The lock, which is held.
    """

    def __init__(self, path: Path, named: Path, contents: Contents, lock: FileLock) -> None:
        self.path, self.named, self.contents = path, named, contents
        self.remarks: list[str] = []
        """What a person should know of what was in the folder before, and of where it is now."""
        self._lock = lock
        self._opened = os.open(path, os.O_RDONLY) if hasattr(os, "O_DIRECTORY") else None
        self._itself = path.stat()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()

    def release(self) -> None:
        """Let other processes write to the folder; may be called more than once."""
        with suppress(OSError):
            self._lock.release(force=True)
        if self._opened is not None:
            os.close(self._opened)
            self._opened = None

    def abandon(self) -> None:
        """Remove what was written to the folder, and the folder where it is empty then."""
        with suppress(OSError):
            remove(self.path, self.contents, self.contents.files)
            for name in (MANIFEST_FILE, LOCK):
                (self.path / name).unlink()
            self.path.rmdir()
        self.release()

    def follow(self) -> bool:
        """Find the folder again, which a person may have renamed or removed; return whether it is the same one.

        In the place of one that was removed there is a new one beside it from now on, which is empty.
        """
        with suppress(OSError):
            if os.path.samestat(self.path.stat(), self._itself):
                return True
        if (moved := self._moved()) is not None:
            self.remarks.append(f"{self.named} was moved during the run: it is {moved} now")
            self.path = self.named = moved
            return True
        self._replace()
        return False

    def _moved(self) -> Path | None:
        """Where the folder is now that was opened, on systems that tell."""
        with suppress(OSError):
            there = Path(f"/proc/self/fd/{self._opened}").readlink()
            if os.path.samestat(there.stat(), self._itself):
                return there
        return None

    def _replace(self) -> None:
        """Go on in a new folder beside the one that is gone."""
        gone, number = self.named, 1
        while (beside := self.path.with_name(f"{self.path.name}-rescued-{number}")).exists():
            number += 1
        self.release()
        told = f"{gone} was removed during the run: what could be saved of it is in {beside}"
        vars(self).update(vars(claim("", beside, self.contents)) | {"remarks": [*self.remarks, told]})


def claim(name: str, out: Path | None, contents: Contents, here: Path | None = None) -> ClaimedFolder:
    """Claim a folder for results: a new one, an empty one, or that of former results of the same kind.

    Args:
        name: What names the folder where `out` does not.
        out: The folder; the next free ``runs/NAME-1``, ``-2``, ... if not given.
        contents: What will be written to it.
        here: What relative paths are relative to; the working folder if not given.

    Returns:
        The folder, in which nothing is left of former results.

    Raises:
        RequestError: Something that is no former result is in the way, another process writes to the folder, or it
            cannot be written to.
    """
    here = here or Path.cwd()
    try:
        if out is None:
            return _next_free(name, contents, here)
        (here / out).mkdir(parents=True, exist_ok=True)
        return _claimed(out, contents, here)
    except OSError as error:
        where, found = str(out or "runs"), f"a folder that cannot be written to ({reason(error)})"
        if isinstance(error, FileExistsError):
            found = "a file" if out is not None and (here / out).is_file() else "a link that leads nowhere"
        raise refuse(where, found, _valid(contents), "Choose another folder with --out.") from error


def reclaim(folder: Path, contents: Contents) -> ClaimedFolder:
    """Claim a folder with results as it is.

    Args:
        folder: The folder.
        contents: What its manifest says that it holds.

    Raises:
        RequestError: It has no such manifest, or another process writes to it.
    """
    if read_manifest(folder, contents) is None:
        found = f"a folder without the {MANIFEST_FILE} of a {contents.kind}"
        raise refuse(str(folder), found, f"a folder that a {contents.kind} has written")
    path = folder.resolve()
    return ClaimedFolder(path, folder, contents, _locked(path, folder, contents))


def _valid(contents: Contents) -> str:
    return f"a folder that is new, empty or a former {contents.kind}, in a place that can be written to"


def _next_free(name: str, contents: Contents, here: Path) -> ClaimedFolder:
    """Make and claim the next free folder; a number is never used twice, however many processes ask at once."""
    (here / "runs").mkdir(exist_ok=True)
    taken = [p.name.rpartition("-")[2] for p in (here / "runs").iterdir() if p.name.rpartition("-")[0] == name]
    for number in count(max((int(n) for n in taken if n.isdecimal()), default=0) + 1):
        named = Path("runs") / f"{name}-{number}"
        try:
            (here / named).mkdir()
            return _claimed(named, contents, here)
        except (FileExistsError, RequestError):  # another process was faster
            continue
    raise AssertionError  # it is endless


def _claimed(named: Path, contents: Contents, here: Path) -> ClaimedFolder:
    folder = (here / named).resolve()
    _owned(folder, named, contents)  # nothing is written to a folder that is somebody else's, not even a lock
    claimed = ClaimedFolder(folder, named, contents, _locked(folder, named, contents))
    try:
        listing = _owned(folder, named, contents)
        raise_if_any(_in_the_way(folder, named, contents, listing))
        remove(folder, contents, listing)
        write_manifest(folder, contents)
    except BaseException:
        claimed.release()
        with suppress(OSError):  # it is not ours, or holds other things
            if [p.name for p in folder.iterdir()] == [LOCK]:
                (folder / LOCK).unlink()
                folder.rmdir()
        raise
    if left := sorted(p.name for p in folder.iterdir() if p.name not in {MANIFEST_FILE, LOCK, *contents.inner}):
        claimed.remarks.append(f"{named}: what else was in this folder stays: {listed(left, _LISTED, 'others')}")
    return claimed


def _locked(folder: Path, named: Path, contents: Contents) -> FileLock:
    lock = FileLock(folder / LOCK, thread_local=False)
    try:
        lock.acquire(blocking=False)
    except Timeout as taken:
        found = f"a folder that {_holder(folder)} is writing to"
        raise refuse(
            str(named), found, _valid(contents), "Wait for it, or choose another folder with --out."
        ) from taken
    with suppress(OSError):
        (folder / LOCK).write_text(str(os.getpid()), encoding="ascii")
    return lock


def _holder(folder: Path) -> str:
    """Who has locked a folder, in words."""
    with suppress(OSError, ValueError):
        number = int((folder / LOCK).read_text(encoding="ascii"))
        return f"this process ({number})" if number == os.getpid() else f"process {number}"
    return "another process"


def _owned(folder: Path, named: Path, contents: Contents) -> set[str]:
    """What former results have written to a folder, by its manifest. Raises `RequestError` where nobody knows it."""
    if all(p.name == LOCK for p in folder.iterdir()):
        return set()
    listing = read_manifest(folder, contents)
    if listing is None:
        what = "a folder with other things in it"
        if any(present(folder, name) for name in contents.files):
            what = f"a folder with files of which no {MANIFEST_FILE} says that a {contents.kind} wrote them"
        raise refuse(str(named), what, _valid(contents), "Choose another folder with --out.")
    return listing


def _in_the_way(folder: Path, named: Path, contents: Contents, listing: set[str]) -> Iterator[Problem]:
    """What would be in the way of new results and is not known to be one of former ones."""
    remedy = "Move it away, or choose another folder with --out."
    valid = f"nothing there but what a former {contents.kind} wrote"
    for name in sorted(contents.folders):
        if (path := folder / name).is_symlink() or (path.exists() and not path.is_dir()):
            yield Problem(str(named / name), _kind(path), valid, remedy)
    for name in contents.files:
        for path in present(folder, name):
            if name not in listing or path.is_symlink() or not path.is_file():
                yield Problem(str(named / path.relative_to(folder)), _kind(path), valid, remedy)


def _kind(path: Path) -> str:
    if path.is_symlink():
        return "a link"
    return "a folder" if path.is_dir() else "a file that is not in its manifest"
