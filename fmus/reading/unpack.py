"""Archives and XML of other tools, unpacked and read; what is broken or could do harm is refused with a message."""

from __future__ import annotations

import posixpath
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections import Counter
from collections.abc import Collection, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from lxml import etree

from components.interfaces.problem import Problem, RequestError, listed, raise_if_any, refuse

MOST_ENTRIES: Final = 100_000
LARGEST_ARCHIVE: Final = 8 * 2**30
"""[byte] The size of all files of an archive together."""
SUSPICIOUS_SIZE: Final = 256 * 2**20
"""[byte] Files that have more together, and more than `LARGEST_RATIO` times the size of the archive, are a zip bomb."""
LARGEST_RATIO: Final = 200
LARGEST_XML: Final = 512 * 2**20
"""[byte] More than the longest description has: an array may have 10 million elements."""
DEEPEST_XML: Final = 256
"""The most elements inside each other."""
_CHUNK: Final = 2**16
_DOCUMENT_TYPE: Final = "a document type declaration (DTD), whose entities could expand without end"
_TOO_DEEP: Final = f"more than {DEEPEST_XML} elements inside each other"


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
            a link, is encrypted, or stands in it twice with different bytes. Only a corrupt archive may have been
            unpacked in part.
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
        return _remarks(archive.infolist())


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
        entries = {_name(entry): entry for entry in archive.infolist() if not _name(entry).endswith("/")}
        contents: dict[str, bytes] = {}
        for name, entry in entries.items():  # each file is read once, and an entry to its end is checked for damage
            if name in names:
                contents[name] = archive.read(entry)
            else:
                _check(archive, entry, where, valid)
        return ArchiveContent(frozenset(entries), contents, _remarks(archive.infolist()))


def _check(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, where: str, valid: str) -> None:
    try:
        with archive.open(entry) as file:
            while file.read(_CHUNK):
                pass
    except zipfile.BadZipFile as error:
        found = f"a corrupt archive ({entry.filename} is damaged)"
        raise refuse(where, found, valid, "Pack or copy it again.") from error


def read_file(path: Path, name: str) -> bytes:
    """The content of one file of an archive that has been read before."""
    with zipfile.ZipFile(path) as archive:
        return archive.read(next(entry for entry in archive.infolist() if _name(entry) == name))


@contextmanager
def _opened(path: Path, folder: Path, where: str, valid: str) -> Generator[zipfile.ZipFile]:
    """An archive whose entries can be unpacked into `folder` without harm."""
    if not path.is_file():
        raise refuse(where, "no such file", valid)
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            raise_if_any(_entry_problems(archive, where, valid))
            raise_if_any(_size_problems(entries, path.stat().st_size, folder, where, valid))
            yield archive
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, OSError) as error:
        if not zipfile.is_zipfile(path):
            raise refuse(where, "a file that is no zip archive", valid) from error
        raise refuse(where, f"a corrupt archive ({error})", valid, "Pack or copy it again.") from error


def _name(entry: zipfile.ZipInfo) -> str:
    return entry.filename.replace("\\", "/")


def _remarks(entries: list[zipfile.ZipInfo]) -> tuple[str, ...]:
    """A remark on files that stand in the archive more than once, with the same bytes."""
    counts = Counter(name for entry in entries if not (name := _name(entry)).endswith("/"))
    repeated = [name for name, count in counts.items() if count > 1]
    return (f"the archive has {listed(repeated)} more than once, with the same bytes",) if repeated else ()


def _entry_problems(archive: zipfile.ZipFile, where: str, valid: str) -> list[Problem]:
    problems: list[Problem] = []
    seen: dict[str, zipfile.ZipInfo] = {}
    for entry in archive.infolist():
        name = _name(entry)
        found, remedy = None, ""
        if _leaves(name):
            found = "an entry that would leave the folder"
        elif entry.flag_bits & 1:
            found, remedy = "an encrypted entry", "Pack it without a password."
        elif stat.S_ISLNK(entry.external_attr >> 16):
            found, remedy = "a symbolic link", "Pack the file that it leads to."
        elif name in seen and not name.endswith("/") and not _are_equal(archive, seen[name], entry):
            found, remedy = "two entries of one name with different bytes", "Pack it again."
        if found:
            problems.append(Problem(where, f"{found}, {entry.filename}", valid, remedy))
        seen.setdefault(name, entry)
    return problems


def _are_equal(archive: zipfile.ZipFile, first: zipfile.ZipInfo, second: zipfile.ZipInfo) -> bool:
    """Whether two entries have the same bytes, which a damaged one never has."""
    if (first.file_size, first.CRC) != (second.file_size, second.CRC):
        return False
    with archive.open(first) as a, archive.open(second) as b:
        while (part := a.read(2**20)) == b.read(2**20):
            if not part:
                return True
    return False


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
    without end or refer to other files. Texts and attributes may be as long as the document: the start value of an
    array is one attribute.

    Args:
        content: The document.
        where: The document, as messages name it.
        valid: What it should be, as messages say it.

    Raises:
        RequestError: The document is not well-formed, in which case the message has the line, has a document type
            declaration, or is too large or nested too deeply.
    """
    if len(content) > LARGEST_XML:
        found = f"{len(content) / 2**20:.0f} MiB of XML"
        raise refuse(where, found, f"at most {LARGEST_XML / 2**20:.0f} MiB of XML in one file")
    parser = _parser(huge_tree=False)
    try:
        root = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        errors = parser.error_log.filter_from_errors()
        if _has_document_type(content):
            raise refuse(where, _DOCUMENT_TYPE, valid) from error
        if not errors or errors[0].type_name != "ERR_RESOURCE_LIMIT":
            raise _not_well_formed(error, errors, where, valid) from error
        root = _large(content, where, valid)
    if root.getroottree().docinfo.internalDTD is not None:
        raise refuse(where, _DOCUMENT_TYPE, valid)
    return root


def _parser(*, huge_tree: bool) -> Any:
    return etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=huge_tree)


def _large(content: bytes, where: str, valid: str) -> Any:
    """The root element of a document, without entities, that is beyond the usual limits of the parser."""
    parser = _parser(huge_tree=True)
    try:
        root = etree.fromstring(content, parser)
    except etree.XMLSyntaxError as error:
        errors = parser.error_log.filter_from_errors()
        if errors and errors[0].type_name == "ERR_RESOURCE_LIMIT":
            raise refuse(where, _TOO_DEEP, valid) from error
        raise _not_well_formed(error, errors, where, valid) from error
    level: list[Any] = [root]
    for _ in range(DEEPEST_XML):
        level = [child for element in level for child in element]
    if level:
        raise refuse(where, _TOO_DEEP, valid)
    return root


def _has_document_type(content: bytes) -> bool:
    """Whether there is a document type declaration, which can only stand before the root element."""
    parser = etree.XMLPullParser(("start",), resolve_entities=False, no_network=True, load_dtd=False)
    try:
        for at in range(0, len(content), _CHUNK):
            parser.feed(content[at : at + _CHUNK])
            for _, root in parser.read_events():
                return root.getroottree().docinfo.internalDTD is not None
    except etree.XMLSyntaxError:
        pass
    return any("<!DOCTYPE".encode(encoding) in content for encoding in ("utf-8", "utf-16-le", "utf-16-be"))


def _not_well_formed(error: Exception, errors: Any, where: str, valid: str) -> RequestError:
    line = getattr(error, "lineno", None)
    reason = errors[0].message if errors else str(error)  # the exception has the line in its message too
    return refuse(f"{where}, line {line}" if line else where, f"XML that is not well-formed ({reason.strip()})", valid)
