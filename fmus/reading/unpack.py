"""Archives of other tools, unpacked and read; what is broken or could do harm is refused with a message."""

from __future__ import annotations

import lzma
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import Problem, RequestError, listed, raise_if_any, refuse
from fmus.toolchain.archives import unwritable
from fmus.toolchain.door import exception_in_words, reading
from fmus.toolchain.file_names import path_problem, plain_path, shown_name
from fmus.toolchain.limits import (
    DEEPEST_PATH,
    LARGEST_ARCHIVE,
    LARGEST_FILE_READ,
    LARGEST_RATIO,
    MOST_ENTRIES,
    SUSPICIOUS_FILE,
    SUSPICIOUS_SIZE,
)

_CHUNK: Final = 2**16
_MOST_SHOWN: Final = 40
"""The most characters of a damaged name in a message."""
_MOST_PROBLEMS: Final = 20
"""The most entries of an archive that are refused by name."""
_METHODS: Final = frozenset({zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA})
_REPACK: Final = "Pack or copy it again."
_DAMAGE: Final = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, NotImplementedError, OSError),
    *(UnicodeError, ValueError, OverflowError, RuntimeError),
)
"""What Python's reader of archives raises on damaged ones."""


@dataclass(frozen=True)
class ArchiveContent:
    """What was read of an archive without unpacking it."""

    names: frozenset[str]
    """The names of all files in it."""
    files: dict[str, bytes]
    """The content of those files that were asked for and are in it."""
    remarks: tuple[str, ...]
    """Remarks for the user on the archive itself."""


def unpack(path: Path, folder: Path, where: str, valid: str) -> tuple[str, ...]:
    """Unpack a zip archive.

    Backslashes in names, as some tools on Windows write them, separate folders.

    Args:
        path: The archive.
        folder: An existing folder.
        where: The archive, as messages name it.
        valid: What the file should be, as messages say it.

    Returns:
        Remarks for the user on the archive.

    Raises:
        RequestError: The archive is missing or corrupt, is a zip bomb, or has an entry that would leave the folder, is
            a link, is encrypted, or stands in it twice with different bytes; or the disk is full. Only a corrupt
            archive may have been unpacked in part.
    """
    with _opened(path, folder, where, valid) as archive:
        for entry in archive.infolist():
            target = folder / _name(entry)
            _write(_parts(archive, entry), target, is_folder=_is_folder(entry))
        return _remarks(archive.infolist())


def _parts(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> Iterator[bytes]:
    """The content of an entry, piece by piece. Raises what Python does where it is damaged."""
    size = 0
    with archive.open(entry) as file:
        while part := file.read(_CHUNK):
            size += len(part)
            yield part
    if size != entry.file_size:
        raise zipfile.BadZipFile(f"{shown_name(entry.filename)} has {size} bytes and says {entry.file_size}")


def _write(source: Iterable[bytes], target: Path, *, is_folder: bool) -> None:
    """Write what is read to a file, which is new, or make a folder."""
    try:
        (target if is_folder else target.parent).mkdir(parents=True, exist_ok=True)
        file = None if is_folder else target.open("wb")
    except OSError as error:
        raise unwritable(target.parent, error) from error
    if file is None:
        return
    with file:
        for part in source:
            try:
                file.write(part)
            except OSError as error:
                raise unwritable(target.parent, error) from error


def read(path: Path, names: Collection[str], where: str, valid: str) -> ArchiveContent:
    """Read files of a zip archive, all files of which are checked for damage.

    Args:
        path: The archive.
        names: The files to be read.
        where: The archive, as messages name it.
        valid: What the file should be, as messages say it.

    Raises:
        RequestError: As `unpack` raises it.
    """
    with _opened(path, Path(tempfile.gettempdir()), where, valid) as archive:
        entries = {_name(entry): entry for entry in archive.infolist() if not _is_folder(entry)}
        raise_if_any(_memory_problems([entries[name] for name in names if name in entries], where, valid))
        contents: dict[str, bytes] = {}
        for name, entry in entries.items():  # each file is read once, and an entry to its end is checked for damage
            if name in names:
                contents[name] = b"".join(_parts(archive, entry))
            else:
                _check(archive, entry, where, valid)
        return ArchiveContent(frozenset(entries), contents, _remarks(archive.infolist()))


def _check(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, where: str, valid: str) -> None:
    try:
        for _ in _parts(archive, entry):
            pass
    except _DAMAGE as error:
        found = f"a corrupt archive ({shown_name(entry.filename)} is damaged)"
        raise refuse(where, found, valid, _REPACK) from error


def checksums(path: Path) -> dict[str, tuple[int, int]]:
    """Size and CRC-32 of each file in an archive that has been read before. Raises what Python does for another."""
    with zipfile.ZipFile(path) as archive:
        return {_name(e): (e.file_size, e.CRC) for e in archive.infolist() if not _is_folder(e)}


def read_file(path: Path, name: str) -> bytes:
    """The content of one file of an archive that has been read before. Raises `RequestError` as `read` does."""
    where = f"{path}, {name}"
    with reading(where, "the file as it was before", _REPACK), zipfile.ZipFile(path) as archive:
        entry = next(entry for entry in archive.infolist() if _name(entry) == name)
        raise_if_any(_memory_problems([entry], str(path), "a file of its usual size"))
        return b"".join(_parts(archive, entry))


@contextmanager
def _opened(path: Path, folder: Path, where: str, valid: str) -> Generator[zipfile.ZipFile]:
    """An archive whose entries can be unpacked into `folder` without harm."""
    if not path.is_file():
        raise refuse(where, "no such file", valid)
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            raise_if_any(_size_problems(entries, path.stat().st_size, folder, where, valid))
            raise_if_any(_entry_problems(archive, where, valid))
            yield archive
    except UnicodeDecodeError as error:
        found = f"an entry whose name is not in UTF-8 as it says ({error.object!r:.{_MOST_SHOWN}})"
        raise refuse(where, found, valid, "Pack it again with another tool.") from error
    except _DAMAGE as error:
        if isinstance(error, RequestError):
            raise
        if not _is_archive(path):
            raise refuse(where, "a file that is no zip archive", valid) from error
        said = str(error) if type(error) in {zipfile.BadZipFile, zlib.error, OSError} else exception_in_words(error)
        raise refuse(where, f"a corrupt archive ({said})", valid, _REPACK) from error


def _is_archive(path: Path) -> bool:
    try:
        return zipfile.is_zipfile(path)
    except (OSError, ValueError, OverflowError):
        return False


def _name(entry: zipfile.ZipInfo) -> str:
    """The path of an entry in one spelling, in which two entries of one file have the same."""
    return plain_path(entry.filename)


def _is_folder(entry: zipfile.ZipInfo) -> bool:
    return entry.filename.endswith(("/", "\\"))


def _remarks(entries: list[zipfile.ZipInfo]) -> tuple[str, ...]:
    """A remark on files that stand in the archive more than once, with the same bytes."""
    counts = Counter(_name(entry) for entry in entries if not _is_folder(entry))
    repeated = [name for name, count in counts.items() if count > 1]
    return (f"the archive has {listed(repeated)} more than once, with the same bytes",) if repeated else ()


def _entry_problems(archive: zipfile.ZipFile, where: str, valid: str) -> list[Problem]:
    problems: list[Problem] = []
    seen: dict[str, zipfile.ZipInfo] = {}
    entries = archive.infolist()
    folders = {parent for entry in entries for parent in _folders(entry)}
    for entry in entries:
        found, remedy = _entry_breach(archive, entry, seen, folders)
        if found:
            problems.append(Problem(where, f"{found}, {shown_name(entry.filename)}", valid, remedy))
        if len(problems) >= _MOST_PROBLEMS:
            break
        if not _is_folder(entry):
            seen.setdefault(_name(entry), entry)
    return problems


def _entry_breach(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, seen: Mapping[str, zipfile.ZipInfo], folders: AbstractSet[str]
) -> tuple[str, str]:
    """What is wrong with an entry after those that have been `seen`, and what to do; empty texts where nothing is."""
    name, is_file = _name(entry), not _is_folder(entry)
    if not name and not is_file and (entry.filename[0] == "."):
        return "", ""  # the folder that it is unpacked into
    reason = path_problem(entry.filename)
    rules: tuple[tuple[Callable[[], Any], str, str], ...] = (
        (lambda: reason, f"an entry that {reason}", ""),
        (lambda: entry.flag_bits & 1, "an encrypted entry", "Pack it without a password."),
        (lambda: stat.S_ISLNK(entry.external_attr >> 16), "a symbolic link", "Pack the file that it leads to."),
        (
            lambda: entry.compress_type not in _METHODS,
            f"an entry packed by the method {entry.compress_type}",
            "Pack it again with the method `deflate`.",
        ),
        (lambda: is_file and name in folders, "a file that is a folder, too", "Pack it again."),
        (
            lambda: is_file and name in seen and not _are_equal(archive, seen[name], entry),
            "two entries of one name with different bytes",
            "Pack it again.",
        ),
    )
    return next(((found, remedy) for is_broken, found, remedy in rules if is_broken()), ("", ""))


def _folders(entry: zipfile.ZipInfo) -> Iterator[str]:
    """The folders that an entry needs, itself included if it is one."""
    name = _name(entry)
    if _is_folder(entry) and name:
        yield name
    if name.count("/") <= DEEPEST_PATH:
        while (at := name.rfind("/")) > 0:
            name = name[:at]
            yield name


def _are_equal(archive: zipfile.ZipFile, first: zipfile.ZipInfo, second: zipfile.ZipInfo) -> bool:
    """Whether two entries have the same bytes, which a damaged one never has."""
    if (first.file_size, first.CRC) != (second.file_size, second.CRC):
        return False
    with archive.open(first) as a, archive.open(second) as b:
        while (part := a.read(2**20)) == b.read(2**20):
            if not part:
                return True
    return False


def _size_problems(entries: list[zipfile.ZipInfo], packed: int, folder: Path, where: str, valid: str) -> list[Problem]:
    """The reasons not to unpack so much; an entry never has more bytes than its header says."""
    size = sum(entry.file_size for entry in entries)
    sizes = f"{size / 2**20:.0f} MiB in an archive of {packed / 2**20:.3g} MiB"
    if len(entries) > MOST_ENTRIES:
        return [Problem(where, f"{len(entries)} entries", f"at most {MOST_ENTRIES}")]
    if size > LARGEST_ARCHIVE or (size > SUSPICIOUS_SIZE and size > LARGEST_RATIO * packed):
        return [Problem(where, f"a zip bomb ({sizes})", valid)]
    if size > shutil.disk_usage(folder).free:
        return [Problem(where, sizes, f"what fits on the disk of {folder}", "Set TMPDIR to a folder with more room.")]
    return []


def _memory_problems(entries: Sequence[zipfile.ZipInfo], where: str, valid: str) -> Iterator[Problem]:
    """The reasons not to read files into memory."""
    for entry in entries:
        size, packed = entry.file_size, entry.compress_size
        if size > SUSPICIOUS_FILE and size > LARGEST_RATIO * packed:
            found = f"a zip bomb ({entry.filename}: {size / 2**20:.0f} MiB out of {packed / 2**20:.3g} MiB)"
            yield Problem(where, found, valid)
        elif size > LARGEST_FILE_READ:
            found, most = f"{entry.filename} of {size / 2**20:.0f} MiB", f"at most {LARGEST_FILE_READ / 2**20:.0f} MiB"
            yield Problem(where, found, most)
