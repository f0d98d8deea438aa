"""FMUs without a binary for this platform: compiled once from the C sources in them, and kept in the user's cache."""

from __future__ import annotations

import hashlib
import posixpath
import re
import shlex
import shutil
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from components.interfaces.problem import Problem, listed, raise_if_any, refuse
from components.interfaces.progress import SILENT, Progress
from fmus.reading.archive import Archive
from fmus.reading.build_options import harmless
from fmus.reading.unpack import read_file
from fmus.reading.xml_documents import parse_xml
from fmus.toolchain.archives import BUILD_DESCRIPTION
from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.file_names import path_problem, shown_name
from fmus.toolchain.fmpy_library import C_HEADERS
from fmus.toolchain.kept_libraries import keep, kept_library
from fmus.toolchain.limited_command import CommandLimits, run_limited
from fmus.toolchain.limits import COMPILING_MEMORY, COMPILING_OUTPUT, COMPILING_TIME
from fmus.toolchain.platform_names import platform_tuple
from fmus.toolchain.version import Version

_OLD_C: Final = ("-w", *(f"-Wno-error={name}" for name in ("implicit-function-declaration", "int-conversion")))
"""Much of what tools write is accepted by a compiler of its time, but is an error for one of today."""
_ALL: Final = "all.c"
_VALID: Final = "sources that a C compiler takes"
_LINES_SHOWN: Final = 3
_LONGEST_LINE: Final = 300
_COMPLAINT: Final = re.compile(r"error|out of memory|limit exceeded|cannot allocate", re.IGNORECASE)
_LIMITS: Final = CommandLimits(COMPILING_TIME, COMPILING_MEMORY, COMPILING_OUTPUT)


@dataclass(frozen=True)
class CSources:
    """The C files of an FMU, and how they are compiled."""

    files: tuple[str, ...]
    options: tuple[str, ...] = ()
    libraries: tuple[str, ...] = ()
    origin: str = "the sources inside"
    """Where they are from, in words."""
    left_out: tuple[str, ...] = ()
    """What their maker wants of the compiler and does not get, because it can do harm."""


def declared_sources(archive: Archive) -> CSources | None:
    """The C files of an FMU; None where it has none.

    An FMU of FMI 2.0 that declares none may have some all the same: then all of them in the folder `sources` are
    compiled, or one that is called `all.c` and includes the others.

    Raises:
        RequestError: The build description of FMI 3.0 cannot be understood, or a file would not be in its folder.
    """
    sources = _sources(archive)
    if sources is not None:
        valid = "the path of a file in the folder `sources`"
        outside = [(name, reason) for name in sources.files if (reason := path_problem(name))]
        raise_if_any(Problem(archive.where, f"the source file `{shown_name(n)}`, which {r}", valid) for n, r in outside)
    return sources


def _sources(archive: Archive) -> CSources | None:
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


def kept_for(archive: Archive) -> Path:
    """Where the library of an FMU is kept once it has been compiled.

    Raises:
        RequestError: There is no compiler.
    """
    stamp = f"{platform_tuple()} {required_compiler().identity} {archive.interface_type.modelIdentifier}".encode()
    with archive.path.open("rb") as file:
        key = hashlib.file_digest(file, lambda: hashlib.sha256(stamp)).hexdigest()[:32]
    return kept_library(key)


def compile_library(archive: Archive, folder: Path, target: Path, progress: Progress = SILENT) -> None:
    """Compile the library of an FMU, or copy it from the cache when it was compiled before.

    Args:
        archive: The FMU.
        folder: The folder in which it is unpacked.
        target: The file of the library.
        progress: Is told before the compiler is called.

    Raises:
        RequestError: There is no compiler, or the sources do not compile.
    """
    compiler, kept = required_compiler(), kept_for(archive)
    if kept.is_file():
        shutil.copyfile(kept, target)
        return
    progress.done(f"compiling C of {archive.where} for this platform, for at most {COMPILING_TIME:g} s")
    _compile(compiler.command, declared_sources(archive) or CSources(()), folder / "sources", target, archive.where)
    with suppress(OSError):  # without a cache, the library is compiled each time
        keep(target, kept)


def _described(archive: Archive) -> CSources:
    """The sources that a build description of FMI 3.0 declares."""
    identifier = archive.interface_type.modelIdentifier
    place = f"{archive.where}, {BUILD_DESCRIPTION}"
    description = parse_xml(read_file(archive.path, BUILD_DESCRIPTION), place, "a build description")
    chosen = [c for c in description.iterfind("BuildConfiguration") if c.get("modelIdentifier") == identifier]
    if not chosen:
        raise refuse(place, "no build configuration of this model", f"one with modelIdentifier `{identifier}`")
    wanted: list[str] = []
    for element in chosen[0].iterfind("SourceFileSet"):
        wanted += _options(element.get("compilerOptions", ""), place)
        for macro in element.iterfind("PreprocessorDefinition"):
            value = macro.get("value")
            wanted.append(f"-D{macro.get('name')}" + ("" if value is None else f"={value}"))
        wanted += [f"-I{d.get('name')}" for d in element.iterfind("IncludeDirectory")]
    wanted += [f"-l{e.get('name')}" for e in chosen[0].iterfind("Library") if e.get("external") in {"true", "1"}]
    names = [f.get("name", "") for f in chosen[0].iterfind("SourceFileSet/SourceFile")]
    options = harmless(wanted)
    libraries = [option[2:] for option in options.used if option.startswith("-l")]
    used = tuple(option for option in options.used if not option.startswith("-l"))
    return CSources(tuple(names), used, tuple(libraries), left_out=options.left_out)


def _options(text: str, place: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError as error:
        raise refuse(place, f"compilerOptions `{shown_name(text)}`", "options with closed quotation marks") from error


def _compile(command: Sequence[str], sources: CSources, folder: Path, target: Path, where: str) -> None:
    """Call the compiler once, in the folder of the sources; FMPy's headers of FMI are used if there are none in it."""
    missing = [n for n in sources.files if not (folder / n).is_file()]
    if missing or not sources.files:
        found = f"the source file {missing[0]}, which is not in its folder" if missing else "no source files"
        raise refuse(where, found, _VALID)
    driver = _driver(command, sources.files)
    complete = [] if sys.platform == "darwin" else ["-Wl,--no-undefined"]
    arguments = [*driver, "-O2", *_OLD_C, "-fPIC", "-shared", "-I.", f"-I{C_HEADERS}", *sources.options]
    libraries = [f"-l{name}" for name in dict.fromkeys((*sources.libraries, "m"))]
    files = [f"./{name}" if name.startswith(("-", "@")) else name for name in sources.files]  # no options of its own
    arguments += [*files, "-o", str(target), *complete, *libraries]
    done = run_limited(arguments, folder, _LIMITS, {"LC_ALL": "C"})
    if done.code is None:
        found = f"no binary for {platform_tuple()}, and sources that do not compile within {COMPILING_TIME:g} s"
        raise refuse(where, found, _VALID, "Have it built for this platform.")
    if done.code != 0:
        lines = [line.strip() for line in done.said.splitlines() if _COMPLAINT.search(line)]
        errors = "; ".join(line[:_LONGEST_LINE] for line in lines[:_LINES_SHOWN])
        ended = f"signal {-done.code}" if done.code < 0 else f"exit code {done.code}"
        found = f"no binary for {platform_tuple()}, and sources that do not compile ({errors or ended})"
        raise refuse(where, found, _VALID, "Have it built for this platform.")


def _driver(command: Sequence[str], names: Sequence[str]) -> list[str]:
    """The compiler; for C++ the C++ compiler in the same folder, which links the C++ library too."""
    if all(Path(name).suffix == ".c" for name in names):
        return list(command)
    program = Path(command[0])
    name = {"gcc": "g++", "clang": "clang++"}.get(program.name, "c++")
    return [str(program.with_name(name)), *command[1:]]
