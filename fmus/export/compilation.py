"""Where C files become FMUs: several compilers at work at once, each file compiled once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from components.interfaces.block import Block
from components.interfaces.maths import Array
from fmus.export.content import Generated, content, generate
from fmus.export.fingerprint import STAMP_PATH, Stamp
from fmus.export.sources import runtime_sources, runtime_units
from fmus.toolchain.archives import write_archive
from fmus.toolchain.compiler import Compiler
from fmus.toolchain.version import Version


@dataclass(frozen=True)
class Part:
    """A block's generated C, and its object files as they come."""

    generated: Generated
    objects: tuple[Future[Path], ...]


class Workshop:
    """A folder of C files and object files; the runtime is compiled once for all blocks."""

    def __init__(self, folder: Path, compiler: Compiler, pool: Executor, versions: Iterable[Version]) -> None:
        self._folder = folder
        self._compiler = compiler
        self._pool = pool
        self._runtime = folder / "runtime"
        self._runtime_objects: dict[str, Future[Path]] = {}
        self._n_parts = 0
        for version in versions:
            _write(self._runtime, runtime_sources(version))
            for name in runtime_units(version):
                if name not in self._runtime_objects:
                    self._runtime_objects[name] = self._compile(self._runtime / name)

    def start(self, block: type[Block[Any, Any, Any]], start: Array) -> Part:
        """Generate the C of a block, in this thread, and have it compiled in others."""
        generated = generate(block, start)
        folder = self._folder / f"{self._n_parts}_{block.name}"
        self._n_parts += 1
        _write(folder, generated.sources)
        return Part(generated, tuple(self._compile(folder / name) for name in generated.sources))

    def finish(self, part: Part, version: Version, path: Path, stamp: Stamp | None) -> Future[None]:
        """Have an FMU linked and written once its object files are there."""
        return self._pool.submit(self._finish, part, version, path, stamp)

    def _compile(self, source: Path) -> Future[Path]:
        return self._pool.submit(self._compiler.compile, source, self._runtime)

    def _finish(self, part: Part, version: Version, path: Path, stamp: Stamp | None) -> None:
        objects = [future.result() for future in part.objects]
        objects += [self._runtime_objects[name].result() for name in runtime_units(version)]
        library = objects[0].parent / f"fmi{version}" / part.generated.interface.block.name
        library.parent.mkdir()
        self._compiler.link(objects, library)
        files = content(part.generated, version, library.read_bytes())
        if stamp is not None:
            files[STAMP_PATH] = stamp.to_bytes()
        write_archive(path, files)


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_bytes(text)
