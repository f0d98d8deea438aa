"""FMUs without a binary for this platform: compiled once from the C sources in them, and kept in the user's cache."""

from __future__ import annotations

import hashlib
import os
import posixpath
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import platformdirs

from components.interfaces.problem import listed, refuse
from fmus.reading.archive import Archive
from fmus.reading.unpack import parse_xml, read_file
from fmus.toolchain.archives import BUILD_DESCRIPTION
from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.fmpy_library import C_HEADERS
from fmus.toolchain.platform_names import platform_tuple
from fmus.toolchain.version import Version

_OLD_C: Final = ("-w", *(f"-Wno-error={name}" for name in ("implicit-function-declaration", "int-conversion")))
"""Much of what tools write is accepted by a compiler of its time, but is an error for one of today."""
_ALL: Final = "all.c"
_VALID: Final = "sources that a C compiler takes"
_LINES_SHOWN: Final = 3


@dataclass(frozen=True)
class CSources:
    """The C files of an FMU, and how they are compiled."""

    files: tuple[str, ...]
    options: tuple[str, ...] = ()
    libraries: tuple[str, ...] = ()
    origin: str = "the sources inside"
    """Where they are from, in words."""


def declared_sources(archive: Archive) -> CSources | None:
    """The C files of an FMU; None where it has none.

    An FMU of FMI 2.0 that declares none may have some all the same: then all of them in the folder `sources` are
    compiled, or one that is called `all.c` and includes the others.

    Raises:
        RequestError: The build description of FMI 3.0 cannot be understood.
    """
    if archive.version == Version.FMI3:
        return _described(archive) if BUILD_DESCRIPTION in archive.files else None
    interfaces = [e for e in archive.root if e.get("modelIdentifier") == archive.interface_type.modelIdentifier]
    names = [str(f.get("name")) for e in interfaces for f in e.iterfind("SourceFiles/File")]
    if names:
        return CSources(tuple(dict.fromkeys(name.replace("\\", "/") for name in names)))
    inside = [name for name in sorted(archive.files) if posixpath.dirname(name) == "sources" and name.endswith(".c")]
    if not inside:
        return None
    files = [_ALL] if _ALL in (names := [posixpath.basename(name) for name in inside]) else names
    return CSources(tuple(files), origin=f"{listed(files)} in its folder of sources, which it does not declare")


def compile_library(archive: Archive, folder: Path, target: Path) -> None:
    """Compile the library of an FMU, or copy it from the cache when it was compiled before.

    Args:
        archive: The FMU.
        folder: The folder in which it is unpacked.
        target: The file of the library.

    Raises:
        RequestError: There is no compiler, or the sources do not compile.
    """
    compiler = required_compiler()
    stamp = f"{platform_tuple()} {compiler.identity} {archive.interface_type.modelIdentifier}".encode()
    key = hashlib.sha256(stamp + archive.path.read_bytes()).hexdigest()[:32]
    kept = platformdirs.user_cache_path("macrostep") / "compiled" / f"{key}{target.suffix}"
    if kept.is_file():
        shutil.copyfile(kept, target)
        return
    _compile(compiler.command, declared_sources(archive) or CSources(()), folder / "sources", target, str(archive.path))
    with suppress(OSError):  # without a cache, the library is compiled each time
        _keep(target, kept)


def _keep(library: Path, kept: Path) -> None:
    """Copy a library to the cache, where it has its name only when complete: other processes may read it."""
    kept.parent.mkdir(parents=True, exist_ok=True)
    partial = kept.with_suffix(f".{os.getpid()}")
    shutil.copyfile(library, partial)
    partial.replace(kept)


def _described(archive: Archive) -> CSources:
    """The sources that a build description of FMI 3.0 declares."""
    identifier = archive.interface_type.modelIdentifier
    place = f"{archive.path}, {BUILD_DESCRIPTION}"
    description = parse_xml(read_file(archive.path, BUILD_DESCRIPTION), place, "a build description")
    chosen = [c for c in description.iterfind("BuildConfiguration") if c.get("modelIdentifier") == identifier]
    if not chosen:
        raise refuse(place, "no build configuration of this model", f"one with modelIdentifier `{identifier}`")
    options: list[str] = []
    for element in chosen[0].iterfind("SourceFileSet"):
        options += _options(element.get("compilerOptions", ""), place)
        for definition in element.iterfind("PreprocessorDefinition"):
            value = definition.get("value")
            options.append(f"-D{definition.get('name')}" + ("" if value is None else f"={value}"))
        options += [f"-I{d.get('name')}" for d in element.iterfind("IncludeDirectory")]
    names = [f.get("name", "") for f in chosen[0].iterfind("SourceFileSet/SourceFile")]
    libraries = [e.get("name") for e in chosen[0].iterfind("Library") if e.get("external") in {"true", "1"}]
    return CSources(tuple(names), tuple(options), tuple(libraries))


def _options(text: str, place: str) -> list[str]:
    try:
        return [option for option in shlex.split(text) if option.startswith("-")]
    except ValueError as error:
        raise refuse(place, f"compilerOptions `{text}`", "options with closed quotation marks") from error


def _compile(command: Sequence[str], sources: CSources, folder: Path, target: Path, where: str) -> None:
    """Call the compiler once, in the folder of the sources; FMPy's headers of FMI are used if there are none in it."""
    outside = [n for n in sources.files if not (folder / n).resolve().is_relative_to(folder.resolve())]
    missing = [n for n in sources.files if not (folder / n).is_file()]
    if outside or missing or not sources.files:
        found = f"the source file {(outside or missing)[0]}" if outside or missing else "no source files"
        raise refuse(where, f"{found}, which is not in its folder" if outside or missing else found, _VALID)
    driver = _driver(command, sources.files)
    complete = [] if sys.platform == "darwin" else ["-Wl,--no-undefined"]
    arguments = [*driver, "-O2", *_OLD_C, "-fPIC", "-shared", "-I.", f"-I{C_HEADERS}", *sources.options]
    libraries = [f"-l{name}" for name in dict.fromkeys((*sources.libraries, "m"))]
    arguments += [*sources.files, "-o", str(target), *complete, *libraries]
    done = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        errors = "; ".join([line.strip() for line in done.stderr.splitlines() if "error" in line][:_LINES_SHOWN])
        found = f"no binary for {platform_tuple()}, and sources that do not compile ({errors})"
        raise refuse(where, found, _VALID, "Have it built for this platform.")


def _driver(command: Sequence[str], names: Sequence[str]) -> list[str]:
    """The compiler; for C++ the C++ compiler in the same folder, which links the C++ library too."""
    if all(Path(name).suffix == ".c" for name in names):
        return list(command)
    program = Path(command[0])
    name = {"gcc": "g++", "clang": "clang++"}.get(program.name, "c++")
    return [str(program.with_name(name)), *command[1:]]
