"""SSP archives of any maker: unpacked, their documents found by URI, parsed and measured by the rules of SSP."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote, urlsplit

from components.interfaces.problem import Problem, RequestError, did_you_mean
from fmus.reading.unpack import parse_xml, unpack
from orchestrator.ssp.rules import DESCRIPTION, Node, breaches, kind_of

VALID: Final = "an SSP: a zip archive with SystemStructure.ssd, SSP 1.0 or 2.0"
_LENIENT: Final = "Have the file corrected by its maker, or read it as it is with --lenient."
_MOST: Final = 20
"""Breaches of the rules that are listed of one document."""


@dataclass
class Findings:
    """What is wrong with an SSP, all of it at once, and what a person should know of it."""

    lenient: bool = False
    """Whether breaches of the standard that do not keep the system from running are only told"""
    problems: list[Problem] = field(default_factory=list[Problem])
    remarks: list[str] = field(default_factory=list[str])

    def wrong(self, where: str, found: str, valid: str, remedy: str = "") -> None:
        """Something that nothing can run with."""
        if (problem := Problem(where, found, valid, remedy)) not in self.problems:
            self.problems.append(problem)

    def breach(self, where: str, found: str, valid: str, remedy: str = _LENIENT) -> None:
        """A rule of the standard that is broken, though the meaning is clear."""
        if not self.lenient:
            self.wrong(where, found, valid, remedy)
        elif (remark := f"{where}: {found}; valid: {valid}") not in self.remarks:
            self.remarks.append(remark)

    def attempt(self, action: Callable[[], Any]) -> Any:
        """What `action` gives, or None where it is refused: then its problems are among these."""
        try:
            return action()
        except RequestError as error:
            self.problems += [p for p in error.problems if p not in self.problems]
            return None


@dataclass(frozen=True)
class Package:
    """An SSP that has been unpacked."""

    folder: Path
    where: str
    """How a person knows it: its path, after those of the SSPs that it lies in"""
    findings: Findings

    @property
    def files(self) -> list[str]:
        """All files in it, by their path from its root."""
        return sorted(p.relative_to(self.folder).as_posix() for p in self.folder.rglob("*") if p.is_file())


@dataclass(frozen=True)
class Document:
    """One XML file of a package."""

    package: Package
    path: Path
    root: Node

    @property
    def where(self) -> str:
        """The package and the file."""
        return f"{self.package.where}, {self.path.relative_to(self.package.folder).as_posix()}"

    def at(self, node: Node, what: str = "") -> str:
        """The file and line of an element, and what it is."""
        return f"{self.where}, line {node.sourceline}" + (f": {what}" if what else "")

    @property
    def findings(self) -> Findings:
        """Where problems go."""
        return self.package.findings


_folders: list[Path] = []


@atexit.register
def remove_packages() -> None:
    """Remove all that was unpacked; for a process that ends without saying so."""
    while _folders:
        shutil.rmtree(_folders.pop(), ignore_errors=True)


def open_package(path: Path, where: str, findings: Findings) -> Package:
    """Unpack an SSP into a folder that lasts as long as this process. Raises `RequestError`."""
    folder = Path(tempfile.mkdtemp(prefix="macrostep_ssp_")).resolve()
    _folders.append(folder)
    unpack(path, folder, where, VALID)
    return Package(folder, where, findings)


def read_document(package: Package, path: Path, wanted: str = DESCRIPTION) -> Document | None:
    """An XML file of a package, or None where it cannot be used: the findings say why. `wanted` is its root element."""
    where = f"{package.where}, {path.relative_to(package.folder).as_posix()}"
    content = path.read_bytes()
    root = package.findings.attempt(lambda: parse_xml(content, where, "well-formed XML without a DTD"))
    if root is None:
        return None
    made = Document(package, path, root)
    return made if is_valid(made, root, wanted) else None


def is_valid(document: Document, root: Node, wanted: str) -> bool:
    """Whether an element, the root or a document inside another, is a `wanted` one of SSP 1 or 2; its breaches told."""
    findings, where = document.findings, document.at(root)
    if kind_of(root) != wanted:
        findings.wrong(where, f"the element `{root.tag}`", f"`{wanted}` of SSP 1.0 or 2.0")
        return False
    version = root.get("version", "")
    if not version:
        findings.breach(where, "no version", "1.0 or 2.0")
    elif version.split(".")[0] not in {"1", "2"}:
        findings.wrong(where, f"SSP version {version}", "1.0 or 2.0")
        return False
    for line, text in list(breaches(root, wanted, version))[:_MOST]:
        findings.breach(f"{document.where}, line {line}", text, f"what SSP {version or '1.0'} allows")
    return True


def resolve(document: Document, uri: str, where: str) -> Path | None:
    """The file that a URI means, relative to its document; None where there is none: the findings say why."""
    package, base = document.package, document.path.parent
    valid = "the relative path of a file in the archive"
    parts = urlsplit(uri)
    if len(parts.scheme) > 1 or parts.netloc:
        package.findings.wrong(where, f"the address `{uri}`", valid, "Put the file into the archive.")
        return None
    for name in (uri, uri.partition("#")[0], unquote(uri.partition("#")[0])):
        path = (base / name).resolve()
        if name.startswith(("/", "\\")) or not path.is_relative_to(package.folder):
            package.findings.wrong(where, f"`{uri}`, which leaves the archive", valid)
            return None
        if path.is_file():
            return path
    package.findings.wrong(where, f"the file `{uri}`, which is not there", valid, did_you_mean(uri, package.files))
    return None
