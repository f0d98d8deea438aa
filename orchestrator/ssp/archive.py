"""SSP archives of any maker: unpacking them, finding their documents by URI, parsing and checking these."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, TypeAlias
from urllib.parse import unquote, urlsplit

from components.interfaces.problem import MOST_PROBLEMS, OTHER_PROBLEMS, Problem, RequestError, did_you_mean, refuse
from fmus.reading.unpack import unpack
from fmus.reading.xml_documents import parse_xml
from fmus.toolchain.door import reading
from fmus.toolchain.file_digest import digest_of
from fmus.toolchain.file_names import LEAVES, path_problem, shown_name
from fmus.toolchain.limits import LARGEST_ARCHIVE, LARGEST_FILE_READ, MOST_SYSTEM_ELEMENTS, MOST_SYSTEMS
from fmus.toolchain.scratch import scratch_folder
from orchestrator.ssp.rules import breaches, document_kind
from orchestrator.ssp.vocabulary import DESCRIPTION_FILE, Attribute, SspVersion, Tag
from orchestrator.ssp.xml import Node

VALID_XML: Final = "well-formed XML without a DTD"
_CORRECT_IT: Final = "Have the file corrected by its maker, or read it as it is with --lenient."
_MOST_BREACHES: Final = 20
"""The breaches of the rules that are listed for one document."""


def alternatives(names: Iterable[str]) -> str:
    """The valid names in their order, as `a, b or c`."""
    *others, last = names
    return f"{', '.join(others)} or {last}" if others else last


VALID_VERSIONS: Final = alternatives(SspVersion)
VALID_PACKAGE: Final = f"an SSP: a zip archive with {DESCRIPTION_FILE}"
VALID_SSP: Final = f"{VALID_PACKAGE}, SSP {VALID_VERSIONS}"


@dataclass
class Expansion:
    """How much an SSP becomes, with all that it takes from other files: a small one may stand for a very large one.

    Attributes:
        packages: The digests of the packages.
        size: The bytes of all packages.
        systems: The systems that were taken from elsewhere.
        elements: The elements of all systems.
    """

    packages: set[str] = field(default_factory=set[str])
    size: int = 0
    systems: int = 0
    elements: int = 0

    def add_package(self, content: str, folder: Path, where: str) -> None:
        """Count a package that was unpacked. Raises `RequestError`, if they are too large together."""
        self.packages.add(content)
        self.size += sum(file.stat().st_size for file in folder.rglob("*"))
        if self.size > LARGEST_ARCHIVE:
            found = f"{self.size / 2**20:.0f} MiB with the archives inside"
            raise refuse(where, found, f"at most {LARGEST_ARCHIVE / 2**20:.0f} MiB")

    def add_system(self, where: str) -> None:
        """Count a system that comes from elsewhere. Raises `RequestError`, if there are too many."""
        self.systems += 1
        self._refuse(self.systems, MOST_SYSTEMS, "systems from other places", where)

    def add_element(self, where: str) -> None:
        """Count an element. Raises `RequestError`, if there are too many."""
        self.elements += 1
        self._refuse(self.elements, MOST_SYSTEM_ELEMENTS, "components and systems", where)

    @staticmethod
    def _refuse(number: int, most: int, what: str, where: str) -> None:
        if number > most:
            remedy = "What is taken ten times into what is taken ten times is there a hundred times."
            raise refuse(where, f"an SSP that becomes more than {most} {what}", f"at most {most}", remedy)


@dataclass
class Findings:
    """All the problems of an SSP, and the remarks on it.

    Attributes:
        lenient: Whether a breach of the standard that does not keep the system from running is only a remark.
        problems: What keeps the system from running; the same may be there several times.
        remarks: What a person should know of a system that runs, likewise.
        expansion: What the SSP has become so far.
    """

    lenient: bool = False
    problems: list[Problem] = field(default_factory=list[Problem])
    remarks: list[str] = field(default_factory=list[str])
    expansion: Expansion = field(default_factory=Expansion)

    def add_problem(self, where: str, found: str, valid: str, remedy: str = "") -> None:
        """Add a problem that keeps the system from running. Raises `RequestError` if there are too many."""
        self.problems.append(Problem(where, found, valid, remedy))
        if len(self.problems) > MOST_PROBLEMS:
            raise self.refusal()

    def add_breach(self, where: str, found: str, valid: str, remedy: str = _CORRECT_IT) -> None:
        """Add a breach of the standard whose meaning is clear: a problem, or a remark for a lenient reader."""
        if not self.lenient:
            self.add_problem(where, found, valid, remedy)
        else:
            self.remarks.append(f"{where}: {found}; valid: {valid}")

    def attempt(self, action: Callable[[], Any]) -> Any:
        """The result of `action`; None where it raises `RequestError`, whose problems are added."""
        try:
            return action()
        except RequestError as error:
            self.problems += error.problems
            return None

    def refusal(self) -> RequestError:
        """The error that lists each problem once, or as many as are looked for."""
        once = [*dict.fromkeys(self.problems)]
        return RequestError(once if len(once) <= MOST_PROBLEMS else [*once[:MOST_PROBLEMS], OTHER_PROBLEMS])


@dataclass(frozen=True)
class Package:
    """An SSP that has been unpacked into a folder.

    Attributes:
        folder: The folder that holds the content.
        where: The path of the SSP for messages, after those of the SSPs that contain it.
        findings: Where problems are gathered.
    """

    folder: Path
    where: str
    findings: Findings

    @property
    def files(self) -> list[str]:
        """The paths of all files, relative to the root of the archive."""
        return sorted(p.relative_to(self.folder).as_posix() for p in self.folder.rglob("*") if p.is_file())


@dataclass(frozen=True)
class Document:
    """One XML file of a package."""

    package: Package
    path: Path
    root: Node

    @cached_property
    def where(self) -> str:
        """The package and the file, for messages."""
        return f"{self.package.where}, {self.path.relative_to(self.package.folder).as_posix()}"

    def at(self, node: Node, what: str = "") -> str:
        """The file and the line of an element, and what the element is, for messages."""
        return f"{self.where}, line {node.sourceline}" + (f": {what}" if what else "")

    @property
    def findings(self) -> Findings:
        """Where problems are gathered."""
        return self.package.findings


_Unpacked: TypeAlias = dict[str, tuple[TemporaryDirectory[str], tuple[str, ...]]]
"""By the SHA-256 of an archive, where it has been unpacked, and the remarks on it."""
_unpacked: ContextVar[_Unpacked] = ContextVar("unpacked", default={})  # noqa: B039 - it is meant to be shared


@contextmanager
def removed_packages() -> Generator[None]:
    """Remove at the end of the statement what is unpacked in it: for a system that is read, and does not run."""
    own: _Unpacked = {}
    token = _unpacked.set(own)
    try:
        yield
    finally:
        _unpacked.reset(token)
        for folder, _ in own.values():
            folder.cleanup()


def open_package(path: Path, where: str, findings: Findings) -> Package:
    """Unpack an SSP, once for each content, into a folder that lasts as long as this process.

    Args:
        path: The archive.
        where: Its path for messages.
        findings: Where the problems of its documents are gathered.

    Raises:
        RequestError: The file is not a zip archive, or an entry would leave the folder.
    """
    known, content = _unpacked.get(), digest(path)
    if content not in known:
        new = scratch_folder("ssp")
        try:
            known[content] = new, unpack(path, Path(new.name), where, VALID_SSP)
        except RequestError:
            new.cleanup()
            raise
    folder, remarks = known[content]
    if content not in findings.expansion.packages:
        findings.expansion.add_package(content, Path(folder.name), where)
        findings.remarks += remarks
    return Package(Path(folder.name), where, findings)


def digest(path: Path) -> str:
    """The digest of a file, by which two of the same content are known; empty where there is none to be read."""
    try:
        return digest_of(path)
    except OSError:
        return ""


def read_document(package: Package, path: Path, kind: Tag = Tag.DESCRIPTION) -> Document | None:
    """An XML file of a package, whose root element must be `kind`; None where the findings say why it is unusable."""
    where = f"{package.where}, {path.relative_to(package.folder).as_posix()}"
    root = package.findings.attempt(lambda: parse_xml(file_content(path, where), where, VALID_XML))
    if root is None:
        return None
    document = Document(package, path, root)
    return document if conforms(document, root, kind) else None


def file_content(path: Path, where: str) -> bytes:
    """The content of a file of a package. Raises `RequestError` for one that is too large."""
    with reading(where, "a file that can be read"):
        if (size := path.stat().st_size) > LARGEST_FILE_READ:
            raise refuse(where, f"{size / 2**20:.0f} MiB", f"at most {LARGEST_FILE_READ / 2**20:.0f} MiB")
        return path.read_bytes()


def conforms(document: Document, root: Node, kind: Tag) -> bool:
    """Check a document, or one that stands inside another; the findings get its breaches of the rules.

    Args:
        document: The file.
        root: Its root element, or that of the document inside.
        kind: The root element that is wanted.

    Returns:
        Whether the document is of this kind and of a version that can be read.
    """
    findings, where = document.findings, document.at(root)
    if document_kind(root) is not kind:
        findings.add_problem(where, f"the element `{root.tag}`", f"`{kind}` of SSP {VALID_VERSIONS}")
        return False
    text = root.get(Attribute.VERSION, "")
    version = SspVersion.of(text) if text else SspVersion.SSP1
    if not text:
        findings.add_breach(where, "no version", VALID_VERSIONS)
    if version is None:
        findings.add_problem(where, f"SSP version {text}", VALID_VERSIONS)
        return False
    for line, found in islice(breaches(root, kind, version), _MOST_BREACHES):
        findings.add_breach(f"{document.where}, line {line}", found, f"what SSP {text or version} allows")
    return True


def resolve_uri(document: Document, uri: str, where: str) -> Path | None:
    """The file that a URI means, relative to its document; None where there is none, as the findings say."""
    package, base = document.package, document.path.parent
    valid = "the relative path of a file in the archive"
    if _is_address(uri):
        package.findings.add_problem(where, f"the address `{shown_name(uri)}`", valid, "Put the file into the archive.")
        return None
    inside = base.relative_to(package.folder).as_posix()
    for name in (uri, uri.partition("#")[0], unquote(uri.partition("#")[0])):
        if reason := path_problem(name if name.startswith(("/", "\\")) else f"{inside}/{name}"):
            leaves = "which leaves the archive" if reason == LEAVES else f"which {reason}"
            package.findings.add_problem(where, f"`{shown_name(uri)}`, {leaves}", valid)
            return None
        path = (base / name).resolve()
        if path.is_relative_to(package.folder) and path.is_file():
            return path
    missing = f"the file `{shown_name(uri)}`, which is not there"
    package.findings.add_problem(where, missing, valid, did_you_mean(uri, package.files))
    return None


def _is_address(uri: str) -> bool:
    """Whether a URI leads to another machine, or to another place on this one."""
    try:
        parts = urlsplit(uri)
    except ValueError:  # such as `http://[half`
        return True
    return len(parts.scheme) > 1 or bool(parts.netloc)
