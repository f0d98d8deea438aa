"""Archives and XML of other tools, unpacked and read; what is broken or could do harm is refused with a message."""

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
LARGEST_ARCHIVE: Final = 8 * 2**30
"""[byte] The size of all files of an archive together."""
SUSPICIOUS_SIZE: Final = 256 * 2**20
"""[byte] Files that have more together, and more than `LARGEST_RATIO` times the size of the archive, are a zip bomb."""
LARGEST_RATIO: Final = 200


def unpack(path: Path, folder: Path, where: str, valid: str) -> None:
    """Unpack a zip archive.

    Backslashes in names, as some tools on Windows write them, separate folders.

    Args:
        path: The archive.
        folder: An existing folder.
        where: The archive, as messages name it.
        valid: What the file should be, as messages say it.

    Raises:
        RequestError: The archive is missing or corrupt, is a zip bomb, or has an entry that would leave the folder, is
            a link or is encrypted. Only a corrupt archive may have been unpacked in part.
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
    """Read files of a zip archive, all files of which are checked for damage.

    Args:
        path: The archive.
        names: The files to be read.
        where: The archive, as messages name it.
        valid: What the file should be, as messages say it.

    Returns:
        The names of all files of the archive, and the content of those of `names` that are in it.

    Raises:
        RequestError: As `unpack` raises it.
    """
    with _opened(path, Path(tempfile.gettempdir()), where, valid) as archive:
        entries = {_name(entry): entry for entry in archive.infolist() if not _name(entry).endswith("/")}
        contents = {name: archive.read(entry) for name, entry in entries.items() if name in names}
        if damaged := archive.testzip():
            raise refuse(where, f"a corrupt archive ({damaged} is damaged)", valid, "Pack or copy it again.")
        return frozenset(entries), contents


@contextmanager
def _opened(path: Path, folder: Path, where: str, valid: str) -> Generator[zipfile.ZipFile]:
    """An archive whose entries can be unpacked into `folder` without harm."""
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
    problems: list[Problem] = []
    seen: set[str] = set()
    for entry in entries:
        name = _name(entry)
        found, remedy = None, ""
        if _leaves(name):
            found = "an entry that would leave the folder"
        elif entry.flag_bits & 1:
            found, remedy = "an encrypted entry", "Pack it without a password."
        elif stat.S_ISLNK(entry.external_attr >> 16):
            found, remedy = "a symbolic link", "Pack the file that it leads to."
        elif name in seen:
            found, remedy = "two entries of one name", "Pack it again."
        if found:
            problems.append(Problem(where, f"{found}, {entry.filename}", valid, remedy))
        seen.add(name)
    return problems


def _leaves(name: str) -> bool:
    """Whether a name leads out of the folder that it is unpacked into, which no link can do: links are refused."""
    normal = posixpath.normpath(name)
    return normal.startswith(("/", "../")) or normal == ".." or normal[1:2] == ":"


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


def parse_xml(content: bytes, where: str, valid: str) -> Any:
    """The root element of an XML document.

    Documents with a document type declaration are refused: neither FMI nor SSP has one, and its entities may expand
    without end or refer to other files.

    Args:
        content: The document.
        where: The document, as messages name it.
        valid: What it should be, as messages say it.

    Raises:
        RequestError: The document is not well-formed, in which case the message has the line, or has a document type
            declaration.
    """
    declaration = "a document type declaration (DTD), whose entities could expand without end"
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    try:
        root = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        if b"<!DOCTYPE" in content:
            raise refuse(where, declaration, valid) from error
        line = getattr(error, "lineno", None)
        errors = parser.error_log.filter_from_errors()  # the exception has the line in its message too
        reason = errors[0].message if errors else str(error)
        raise refuse(
            f"{where}, line {line}" if line else where, f"XML that is not well-formed ({reason})", valid
        ) from error
    if root.getroottree().docinfo.internalDTD is not None:
        raise refuse(where, declaration, valid)
    return root
