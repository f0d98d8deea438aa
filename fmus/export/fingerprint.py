"""Whether an FMU is the one that would be built now, determined without generating anything."""

from __future__ import annotations

import hashlib
import json
import sys
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import components.interfaces
import fmus
from components.interfaces.block import Block
from components.interfaces.maths import Array
from fmus.export.description_parts import tool_version
from fmus.export.own_builds import STAMP_PATH
from fmus.toolchain.compiler import FLAGS, Compiler
from fmus.toolchain.platform_names import platform_tuple
from fmus.toolchain.version import Version

_SUFFIXES = (".py", ".c", ".h")


@dataclass(frozen=True)
class Stamp:
    """The identity of everything that an FMU is built from."""

    sources: str
    """Digest of all sources that the FMU depends on, its start values, and the versions of the generators."""
    compiler: str
    """The compiler, its flags and its platform."""

    def to_bytes(self) -> bytes:
        """The file inside the FMU."""
        return (json.dumps({"sources": self.sources, "compiler": self.compiler}, indent=2) + "\n").encode()

    def fits(self, path: Path, *, with_compiler: bool) -> bool:
        """Whether the FMU at `path` carries this stamp.

        Args:
            path: The FMU.
            with_compiler: Whether the compiler has to be the same too.
        """
        try:
            with zipfile.ZipFile(path) as archive:
                kept = Stamp(**json.loads(archive.read(STAMP_PATH)))
        except (OSError, KeyError, TypeError, ValueError, zipfile.BadZipFile, zlib.error):  # not an FMU of ours
            return False
        return kept.sources == self.sources and (not with_compiler or kept.compiler == self.compiler)


def stamp(block: type[Block[Any, Any, Any]], fmi: Version, start: Array, compiler: Compiler | None) -> Stamp | None:
    """The stamp of an FMU that is built now.

    Args:
        block: The block.
        fmi: The version of FMI.
        start: Start values of the parameters, one column in the order of `block.parameters()`.
        compiler: The C compiler; None where there is none.

    Returns:
        The stamp; None where the block's source is in no file, so that the FMU must be built anew each time.
    """
    foreign = _foreign_sources(block)
    if foreign is None:
        return None
    digest = hashlib.sha256(package_digest().encode())
    for part in (f"{block.__module__}.{block.__qualname__}", f"fmi{fmi}", start.tobytes().hex(), *foreign):
        digest.update(part.encode() + b"\0")
    identity = compiler.identity if compiler is not None else ""
    return Stamp(digest.hexdigest(), " ".join([identity, *FLAGS, platform_tuple()]))


@lru_cache(maxsize=1)
def package_digest() -> str:
    """Digest of the sources of `components` and `fmus`, read once per process, and of the versions of their tools."""
    digest = hashlib.sha256()
    for name in ("casadi", "fmpy", "lxml", "numpy"):
        digest.update(f"{name} {version(name)}\0".encode())
    digest.update(tool_version().encode())
    for folder in _package_folders():
        for path in sorted(p for p in folder.rglob("*") if p.suffix in _SUFFIXES):
            digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0")
            digest.update(path.read_bytes() + b"\0")
    return digest.hexdigest()


def _package_folders() -> list[Path]:
    return [Path(components.interfaces.__path__[0]).parent, Path(fmus.__path__[0])]


def _foreign_sources(block: type[Block[Any, Any, Any]]) -> list[str] | None:
    """Digests of what defines the block and its records outside our packages: its own, and those of files.

    None where a class is defined in no file.
    """
    digests: list[str] = [block.definition]
    for path in _defining_files(block):
        if path is None:
            return None
        if not any(path.is_relative_to(folder) for folder in _package_folders()):
            digests.append(hashlib.sha256(path.read_bytes()).hexdigest())
    return digests


def _defining_files(block: type[Block[Any, Any, Any]]) -> Iterator[Path | None]:
    classes = (*block.__mro__, block.input_type, block.state_type, block.output_type)
    for module in dict.fromkeys(cls.__module__ for cls in classes):
        if module in sys.builtin_module_names or module in sys.stdlib_module_names:
            continue
        name = getattr(sys.modules.get(module), "__file__", None)
        yield Path(name) if name and Path(name).is_file() else None
