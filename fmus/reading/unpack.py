"""Unpacking archives and reading XML of other makers: refused in words where it is broken, or meant to do harm."""

from __future__ import annotations

import posixpath
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Collection, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from lxml import etree

from components.interfaces.problem import Problem, raise_if_any, refuse

MOST_ENTRIES: Final = 100_000
LARGEST: Final = 8 * 2**30
"""[byte] of all files of an archive together."""
SUSPICIOUS: Final = 256 * 2**20
"""[byte] From here on, files that are more than `LARGEST_RATIO` times their archive are taken to be a zip bomb."""
LARGEST_RATIO: Final = 200


def unpack(path: Path, folder: Path, where: str, valid: str) -> None:
    """Unpack the zip archive `path` into `folder`, which exists. Raises `RequestError`, before anything is written.

    Refused are a missing or corrupt archive, entries that would leave the folder, links, encrypted ones, and zip bombs.
    Backslashes in names, as some tools on Windows write them, separate folders.
    """
    with _opened(path, folder, where, valid) as archive:
        for entry in archive.infolist():
            target = folder / _name(entry)
            if entry.is_dir() or _name(entry).endswith("/"):
                target.mkdir(parents=True, exist_ok=True)
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(entry) as source, target.open("wb") as file:
                shutil.copyfileobj(source, file)


def read(path: Path, names: Collection[str], where: str, valid: str) -> tuple[frozenset[str], dict[str, bytes]]:
    """The names of all files of an archive, and the content of those of `names` that are in it, all of it intact.

    Nothing is written. Raises `RequestError` as `unpack` does.
    """
    with _opened(path, Path(tempfile.gettempdir()), where, valid) as archive:
        entries = {_name(entry): entry for entry in archive.infolist() if not _name(entry).endswith("/")}
        found = {name: archive.read(entry) for name, entry in entries.items() if name in names}
        if damaged := archive.testzip():
            raise refuse(where, f"a corrupt archive ({damaged} is damaged)", valid, "Pack or copy it again.")
        return frozenset(entries), found


@contextmanager
def _opened(path: Path, folder: Path, where: str, valid: str) -> Generator[zipfile.ZipFile]:
    """An archive whose entries may be unpacked into `folder`."""
    if not path.is_file():
        raise refuse(where, "no such file", valid)
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            raise_if_any(_entry_problems(entries, where, valid))
            raise_if_any(_size_problems(entries, path.stat().st_size, folder, where, valid))
            yield archive
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, OSError) as error:
        if not zipfile.is_zipfile(path):
            raise refuse(where, "a file that is no zip archive", valid) from error
        raise refuse(where, f"a corrupt archive ({error})", valid, "Pack or copy it again.") from error


def _name(entry: zipfile.ZipInfo) -> str:
    return entry.filename.replace("\\", "/")


def _entry_problems(entries: list[zipfile.ZipInfo], where: str, valid: str) -> list[Problem]:
    found: list[Problem] = []
    seen: set[str] = set()
    for entry in entries:
        if _leaves(_name(entry)):
            found.append(Problem(where, f"an entry that would leave the folder, {entry.filename}", valid))
        elif entry.flag_bits & 1:
            found.append(Problem(where, f"an encrypted entry, {entry.filename}", valid, "Pack it without a password."))
        elif stat.S_ISLNK(entry.external_attr >> 16):
            found.append(Problem(where, f"a symbolic link, {entry.filename}", valid, "Pack the file that it leads to."))
        elif _name(entry) in seen:
            found.append(Problem(where, f"two entries of one name, {entry.filename}", valid, "Pack it again."))
        seen.add(_name(entry))
    return found


def _leaves(name: str) -> bool:
    """Whether a name leads out of the folder it is unpacked in; there are no links on its way, as they are refused."""
    normal = posixpath.normpath(name)
    return normal.startswith(("/", "../")) or normal == ".." or normal[1:2] == ":"


def _size_problems(entries: list[zipfile.ZipInfo], packed: int, folder: Path, where: str, valid: str) -> list[Problem]:
    """What speaks against unpacking so much; an entry never gives more bytes than its header says."""
    size = sum(entry.file_size for entry in entries)
    told = f"{size / 2**20:.0f} MiB in an archive of {packed / 2**20:.3g} MiB"
    if len(entries) > MOST_ENTRIES:
        return [Problem(where, f"{len(entries)} entries", f"at most {MOST_ENTRIES}")]
    if size > LARGEST or (size > SUSPICIOUS and size > LARGEST_RATIO * packed):
        return [Problem(where, f"a zip bomb ({told})", valid)]
    if size > shutil.disk_usage(folder).free:
        return [Problem(where, told, f"what fits on the disk of {folder}", "Set TMPDIR to a folder with more room.")]
    return []


def parse_xml(content: bytes, where: str, valid: str) -> Any:
    """The root element of an XML document. Raises `RequestError` with the line where it is not well-formed.

    Documents with a document type declaration are refused: neither FMI nor SSP has one, and it may expand without end
    or reach for other files.
    """
    declaration = "a document type declaration (DTD), whose entities could expand without end"
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    try:
        root = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        if b"<!DOCTYPE" in content:
            raise refuse(where, declaration, valid) from error
        line = getattr(error, "lineno", None)
        told = str(getattr(error, "msg", None) or error).partition(", line ")[0]
        raise refuse(
            f"{where}, line {line}" if line else where, f"XML that is not well-formed ({told})", valid
        ) from error
    if root.getroottree().docinfo.internalDTD is not None:
        raise refuse(where, declaration, valid)
    return root
