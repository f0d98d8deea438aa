"""The files of an FMU, unpacked once into the user's cache, where all later openings of the same bytes find them.

They are compared with the archive before the first use in a process, the library by its SHA-256 and the others by their
checksums; before each later use it is only looked whether something has changed since.
"""

from __future__ import annotations

import os
import stat
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple

from components.interfaces.problem import RequestError
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.unpack import checksums, unpack
from fmus.toolchain.file_digest import FileFacts, digest_of, facts_of
from fmus.toolchain.limits import LARGEST_CACHE, MOST_KEPT
from fmus.toolchain.user_cache import UnusableCacheError, UserCache

_CACHE: Final = UserCache("unpacked", LARGEST_CACHE, MOST_KEPT)
_RESOURCES: Final = "resources/"
_CHUNK: Final = 2**20


class KeptFiles(NamedTuple):
    """The files of an FMU in the user's cache."""

    folder: Path | None
    """Where they are; None where the cache cannot be used."""
    remark: str = ""
    """What a person should know of the cache."""


class _Compared(NamedTuple):
    """Files that were those of an archive, and what they were then."""

    folder: Path
    library_digest: str
    facts: dict[str, FileFacts]


_compared: dict[str, _Compared] = {}
"""By the digest of the FMU."""


def sharing(archive: Archive) -> Archive:
    """The FMU, whose units take its files from the user's cache where no FMU can tell the difference.

    Each has files of its own where the FMU has resources, to which some write, where its library is compiled here, and
    where a process can hold only one instance, and so of the library too.
    """
    apart = archive.library is None or archive.only_once or any(name.startswith(_RESOURCES) for name in archive.files)
    return archive if apart else replace(archive, shares_files=True)


def kept_files(archive: Archive) -> KeptFiles:
    """The files of an FMU in the cache, unpacked if they are not there. Nothing may be written to them."""
    try:
        digest = digest_of(archive.path)
        if (folder := _unchanged(digest, archive)) is not None:
            return KeptFiles(folder)
        files = _Files(archive, digest, checksums(archive.path))
    except Exception:  # noqa: BLE001 - the file is gone, or another one: unpacking it tells
        return KeptFiles(None)
    if files.size > LARGEST_CACHE:
        return KeptFiles(None)
    try:
        found = _CACHE.folder(digest, files.size, files.are_in, files.unpack)
    except UnusableCacheError as error:
        return KeptFiles(None, f"its files were unpacked for this run alone, as the cache cannot be used ({error})")
    _compared[digest] = _Compared(found.path, archive.library_digest, files.facts)
    if not found.was_damaged:
        return KeptFiles(found.path)
    return KeptFiles(found.path, f"its files in the cache had changed, and were unpacked again ({found.path})")


def _unchanged(digest: str, archive: Archive) -> Path | None:
    """The folder of files that this process has compared before; None where there is none, or something has changed."""
    compared = _compared.get(digest)
    if compared is None or compared.library_digest != archive.library_digest:
        return None
    folder = compared.folder
    try:
        same = all(facts_of(os.lstat(f"{folder}/{name}")) == facts for name, facts in compared.facts.items())
    except OSError:
        return None
    return folder if same else None


@dataclass
class _Files:
    """The files of an archive, by its digest, with their sizes and checksums."""

    archive: Archive
    digest: str
    wanted: dict[str, tuple[int, int]]

    def __post_init__(self) -> None:
        self.size = sum(size for size, _ in self.wanted.values())
        self.facts: dict[str, FileFacts] = {}
        """What the files were that `are_in` has compared last."""

    def unpack(self, folder: Path) -> None:
        """Unpack them into a new folder. Raises `UnusableCacheError`."""
        try:
            unpack(self.archive.path, folder, self.archive.where, VALID_FMU)
        except RequestError as error:
            raise UnusableCacheError(f"{folder.parent}: {error.problems[0].found}") from error
        if not self.are_in(folder):
            raise UnusableCacheError(f"{folder.parent}: what was unpacked is not what was read before")

    def are_in(self, folder: Path) -> bool:
        """Whether they are the files in a folder: no more, no fewer, and each the same."""
        try:
            found = {path.relative_to(folder).as_posix(): path.lstat() for path in folder.rglob("*")}
            files = {name: facts for name, facts in found.items() if not stat.S_ISDIR(facts.st_mode)}
            self.facts = {name: facts_of(facts) for name, facts in files.items()}
            sizes = {name: facts.st_size if stat.S_ISREG(facts.st_mode) else -1 for name, facts in files.items()}
            return (
                sizes == {name: size for name, (size, _) in self.wanted.items()}
                and all(_checksum(folder / name) == checksum for name, (_, checksum) in self.wanted.items())
                and digest_of(folder / str(self.archive.library)) == self.archive.library_digest
            )
        except OSError:
            return False


def _checksum(path: Path) -> int:
    value = 0
    with path.open("rb") as file:
        while part := file.read(_CHUNK):
            value = zlib.crc32(part, value)
    return value
