"""A quick answer to whether an FMU is what would be built now, without generating anything."""

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
from fmus.toolchain.compiler import FLAGS, Compiler
from fmus.toolchain.platform_names import platform_tuple
from fmus.toolchain.version import Version

STAMP_PATH = "extra/org.macrostep/build.json"
"""Where an FMU keeps the stamp it was built with."""

_SUFFIXES = (".py", ".c", ".h")


@dataclass(frozen=True)
class Stamp:
    """What an FMU was built from."""

    sources: str
    """Digest of all sources that lead to the FMU, its start values, and the versions of the generators."""
    compiler: str
    """The compiler, its flags and its platform."""

    def to_bytes(self) -> bytes:
        """The file inside the FMU."""
        return (json.dumps({"sources": self.sources, "compiler": self.compiler}, indent=2) + "\n").encode()

    def fits(self, path: Path, *, with_compiler: bool) -> bool:
        """Whether the FMU at `path` carries this stamp; `with_compiler` says whether the compiler counts."""
        try:
            with zipfile.ZipFile(path) as archive:
                found = Stamp(**json.loads(archive.read(STAMP_PATH)))
        except (OSError, KeyError, TypeError, ValueError, zipfile.BadZipFile, zlib.error):  # not an FMU of ours
            return False
        return found.sources == self.sources and (not with_compiler or found.compiler == self.compiler)


def stamp(block: type[Block[Any, Any, Any]], fmi: Version, start: Array, compiler: Compiler | None) -> Stamp | None:
    """The stamp of an FMU built now; None when the block's source is not in a file, so that it must always be built."""
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
    """Digest of the sources of `components` and `fmus`, read once per process, and of the tools that use them."""
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
    """Digests of what defines the block and its records outside our packages: its own, and those of files."""
    found: list[str] = [block.definition]
    for path in _defining_files(block):
        if path is None:
            return None
        if not any(path.is_relative_to(folder) for folder in _package_folders()):
            found.append(hashlib.sha256(path.read_bytes()).hexdigest())
    return found


def _defining_files(block: type[Block[Any, Any, Any]]) -> Iterator[Path | None]:
    kinds = (*block.__mro__, block.input_type, block.state_type, block.output_type)
    for module in dict.fromkeys(kind.__module__ for kind in kinds):
        if module in sys.builtin_module_names or module in sys.stdlib_module_names:
            continue
        name = getattr(sys.modules.get(module), "__file__", None)
        yield Path(name) if name and Path(name).is_file() else None
