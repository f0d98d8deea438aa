"""The user's cache: folders that only this user can read or change, each complete or not there, bounded in size.

What is in it can be made again at any time: the folders that were used longest ago are removed, and one that is no
longer what it was is made again.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

import platformdirs

_PARTIAL: Final = ".partial_"
"""How the names of folders begin that are being made, or being removed."""
_LOCK: Final = ".lock"
"""The file that a process locks while it changes what is in the cache."""
_PATIENCE: Final = 10.0
"""[s] The time to wait for another process that does so."""
_OTHERS_WRITE: Final = stat.S_IWGRP | stat.S_IWOTH


class UnusableCacheError(Exception):
    """The cache cannot be used; the message is the folder and the reason."""


class CachedFolder(NamedTuple):
    """A folder in the cache."""

    path: Path
    was_damaged: bool
    """Whether there was one before that had to be made again."""


class UserCache:
    """A part of the user's cache.

    Args:
        name: The name of its folder.
        largest: The most that is kept in it [byte].
        most: The most folders that are kept in it.
    """

    def __init__(self, name: str, largest: int, most: int) -> None:
        self._name, self._largest, self._most = name, largest, most

    @property
    def place(self) -> Path:
        """Where it is, or would be."""
        return platformdirs.user_cache_path("macrostep") / self._name

    def folder(
        self, key: str, size: int, is_sound: Callable[[Path], bool], fill: Callable[[Path], None]
    ) -> CachedFolder:
        """The folder of a key.

        Args:
            key: What tells it from all others: letters and digits.
            size: The size of all that belongs into it [byte].
            is_sound: Whether a folder that is there is what it was.
            fill: Writes all that belongs into a new folder.

        Raises:
            UnusableCacheError: It is not there, and cannot be made.
        """
        try:
            self._make_private()
            wanted = self.place / f"{key}-{size}"  # the size is told without looking at all files
            if _is_folder(wanted) and is_sound(wanted):
                with suppress(OSError):  # on a disk that can only be read
                    os.utime(wanted)  # it is used, so that others go first
                return CachedFolder(wanted, was_damaged=False)
            return self._made(wanted, is_sound, fill)
        except OSError as error:
            raise UnusableCacheError(f"{self.place}: {error.strerror or error}") from error

    def _make_private(self) -> None:
        """Make the folder of all folders, which belongs to this user alone."""
        place = self.place
        place.parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileExistsError):
            place.mkdir(mode=0o700)
        if os.name == "posix":
            _take_from_others(place.parent, _OTHERS_WRITE, _own_mode(place.parent))
            mode = _own_mode(place)
            if mode & _OTHERS_WRITE:  # what is in it may be theirs
                raise UnusableCacheError(f"{place}: other users can write to it")
            _take_from_others(place, stat.S_IRWXG | stat.S_IRWXO, mode)

    def _made(self, wanted: Path, is_sound: Callable[[Path], bool], fill: Callable[[Path], None]) -> CachedFolder:
        """Make a folder that takes its name when it is complete, while no other process changes anything."""
        from filelock import FileLock, Timeout  # noqa: PLC0415 - slow to import, and rarely needed

        place = wanted.parent
        try:
            with FileLock(place / _LOCK, timeout=_PATIENCE, mode=0o600):
                if _is_folder(wanted) and is_sound(wanted):  # another process has made it meanwhile
                    return CachedFolder(wanted, was_damaged=False)
                is_there = os.path.lexists(wanted)
                _remove_partial(place)  # what killed processes have left
                try:
                    new = Path(tempfile.mkdtemp(prefix=_PARTIAL, dir=place))
                    fill(new)
                    if is_there:
                        _put_aside(wanted)
                    self._make_room(wanted)
                    new.rename(wanted)
                finally:
                    _remove_partial(place)
        except Timeout:
            raise UnusableCacheError(f"{place}: another process has been changing it for {_PATIENCE:g} s") from None
        return CachedFolder(wanted, was_damaged=is_there)

    def _make_room(self, wanted: Path) -> None:
        """Put aside the folders that were used longest ago, until one more may join the others."""
        others = sorted(_folders(wanted.parent), key=lambda path: path.stat().st_mtime, reverse=True)
        total = _size(wanted)
        for number, path in enumerate(others, 2):
            total += _size(path)
            if total > self._largest or number > self._most:
                _put_aside(path)


def _own_mode(folder: Path) -> int:
    """The permissions of a folder. Raises `UnusableCacheError` where it is none of this user."""
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise UnusableCacheError(f"{folder}: it is no folder")
    if found.st_uid != os.geteuid():
        raise UnusableCacheError(f"{folder}: it belongs to another user")
    return stat.S_IMODE(found.st_mode)


def _take_from_others(folder: Path, permissions: int, mode: int) -> None:
    if mode & permissions:
        folder.chmod(mode & ~permissions)


def _is_folder(path: Path) -> bool:
    """Whether there is a folder, and no link to one."""
    return path.is_dir() and not path.is_symlink()


def _folders(place: Path) -> Iterator[Path]:
    return (path for path in place.iterdir() if not path.name.startswith(".") and _is_folder(path))


def _put_aside(folder: Path) -> None:
    """Take the name from a folder at once; `_remove_partial` removes it."""
    folder.rename(Path(tempfile.mkdtemp(prefix=_PARTIAL, dir=folder.parent)) / folder.name)


def _remove_partial(place: Path) -> None:
    for path in place.glob(f"{_PARTIAL}*"):
        shutil.rmtree(path, ignore_errors=True)


def _size(folder: Path) -> int:
    """[byte] The size that the name of a folder tells; 0 for one that is none of ours."""
    size = folder.name.rpartition("-")[2]
    return int(size) if size.isdecimal() else 0
