"""C files become FMUs: several compilers run at once, and each file is compiled once for all FMUs that contain it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from components.interfaces.block import Block
from components.interfaces.maths import Array
from fmus.export.c_sources import runtime_files, runtime_sources
from fmus.export.content import Generated, content, generate
from fmus.export.fingerprint import Stamp
from fmus.export.own_builds import STAMP_PATH, note_build
from fmus.toolchain.archives import write_archive
from fmus.toolchain.compiler import Compiler
from fmus.toolchain.version import Version


@dataclass(frozen=True)
class CompiledBlock:
    """A block's generated C, and its object files, whose compilation may still be under way."""

    generated: Generated
    objects: tuple[Future[Path], ...]


class Compilation:
    """The compilation of several FMUs; the runtime is compiled once for all of them.

    Args:
        folder: An empty folder for C files and object files.
        compiler: The C compiler.
        pool: The threads that call it.
        versions: The versions of FMI that are built.
    """

    def __init__(self, folder: Path, compiler: Compiler, pool: Executor, versions: Iterable[Version]) -> None:
        self._folder = folder
        self._compiler = compiler
        self._pool = pool
        self._runtime = folder / "runtime"
        self._runtime_objects: dict[str, Future[Path]] = {}
        self._n_blocks = 0
        wanted = sorted(versions)
        for version in wanted:
            _write(self._runtime, runtime_sources(version))
        # Versions share sources: a compiler must not read one that is just being written for the next version.
        for name in dict.fromkeys(name for version in wanted for name in runtime_files(version)):
            self._runtime_objects[name] = self._compile(self._runtime / name)

    def compile_block(self, block: type[Block[Any, Any, Any]], start: Array) -> CompiledBlock:
        """Generate the C of a block in this thread, and begin to compile it in others.

        Args:
            block: The block.
            start: Start values of the parameters, one column in the order of `block.parameters()`.
        """
        generated = generate(block, start)
        folder = self._folder / f"{self._n_blocks}_{block.name}"
        self._n_blocks += 1
        _write(folder, generated.sources)
        return CompiledBlock(generated, tuple(self._compile(folder / name) for name in generated.sources))

    def write_fmu(self, block: CompiledBlock, version: Version, path: Path, stamp: Stamp | None) -> Future[None]:
        """Link and write an FMU, in another thread, when its object files are complete.

        Args:
            block: The block, as `compile_block` gives it.
            version: The version of FMI.
            path: The file to be written.
            stamp: What the FMU is built from; None for one that must be built anew each time.
        """
        return self._pool.submit(self._write_fmu, block, version, path, stamp)

    def _compile(self, source: Path) -> Future[Path]:
        return self._pool.submit(self._compiler.compile, source, self._runtime)

    def _write_fmu(self, block: CompiledBlock, version: Version, path: Path, stamp: Stamp | None) -> None:
        objects = [future.result() for future in block.objects]
        objects += [self._runtime_objects[name].result() for name in runtime_files(version)]
        library = objects[0].parent / f"fmi{version}" / block.generated.variables.block.name
        library.parent.mkdir()
        self._compiler.link(objects, library)
        files = content(block.generated, version, library.read_bytes())
        if stamp is not None:
            files[STAMP_PATH] = stamp.to_bytes()
        write_archive(path, files)
        note_build(path)


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_bytes(text)
