"""The shared library of an FMU: found or compiled for this platform, loaded, and checked for the functions of FMI."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import hashlib
import os
import posixpath
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import RequestError, listed, refuse
from components.interfaces.progress import SILENT, Progress
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.needed_functions import all_functions, known_function, needed_functions
from fmus.reading.recompile import compile_library, declared_sources, kept_for
from fmus.reading.unpack import read_file, unpack
from fmus.toolchain.binaries import GIT_LFS_POINTER, MachineCode, machine_code
from fmus.toolchain.file_names import shown_name
from fmus.toolchain.fmpy_library import FMICallException, freeLibrary
from fmus.toolchain.function_library import FunctionLibrary, function_prefix
from fmus.toolchain.platform_names import binary_path, in_words, platform_tuple
from fmus.toolchain.scratch import scratch_folder
from fmus.toolchain.system_libraries import not_loaded
from fmus.toolchain.version import Version

_LISTED: Final = 5
"""The number of missing functions that a message lists."""
_GIT_LFS: Final = "Fetch it with `git lfs pull`, and pack it again."
_OVERLOOK: Final = "Have the file corrected by its maker, or run it as it is with --lenient."


def with_library(archive: Archive, *, lenient: bool) -> Archive:
    """The FMU with the path of its library for this platform and what the library says of itself.

    Args:
        archive: The FMU.
        lenient: Whether a library is used although it lacks functions that FMI demands and that no run calls.

    Raises:
        RequestError: There is neither a library for this platform, nor are there sources to compile; or the library
            lacks functions.
    """
    path = _place(archive)
    alternative = binary_path(Version.FMI3, archive.interface_type.modelIdentifier)  # some FMUs of FMI 2.0 use it
    path = path if path in archive.files else alternative
    if path not in archive.files:
        return _noted(archive, _compiled(archive, ""))
    content = read_file(archive.path, path)
    code = machine_code(content)
    other = f"a library for {' and '.join(code.platforms)}" if platform_tuple() not in code.platforms else ""
    if other and (code.platforms or declared_sources(archive) is not None):
        return _noted(archive, _compiled(archive, code.problem or other))
    archive = replace(archive, library=path, library_digest=hashlib.sha256(content).hexdigest(), code=code)
    return archive if code.exports is None else _noted(archive, *_function_remarks(archive, code.exports, lenient))


def platforms(archive: Archive) -> list[str]:
    """The platforms for which the FMU has binaries, by the names of their folders."""
    return sorted({n.split("/")[1] for n in archive.files if n.startswith("binaries/") and n.count("/") > 1})


def _noted(archive: Archive, *remarks: str) -> Archive:
    return replace(archive, remarks=(*archive.remarks, *remarks))


def _place(archive: Archive) -> str:
    """The path that FMI prescribes for the library."""
    return binary_path(archive.version, archive.interface_type.modelIdentifier)


def _compiled(archive: Archive, unusable: str) -> str:
    """The remark on an FMU that is compiled here; `unusable` is what stands in the place of its library, if anything.

    Raises:
        RequestError: There are no sources, or not all of those that it declares.
    """
    sources = declared_sources(archive)
    if sources is None:
        raise _without_library(archive, unusable)
    if missing := [name for name in sources.files if posixpath.normpath(f"sources/{name}") not in archive.files]:
        found = f"no binary for {platform_tuple()}, and no source file sources/{missing[0]}, which it declares"
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        valid = f"all its source files, or a binary for {platform_tuple()} ({_place(archive)})"
        raise refuse(archive.where, found + more, valid, "Ask its maker for a complete export.")
    reason = f"no binary for {platform_tuple()}" + (f" ({unusable} in its place)" if unusable else "")
    without = (
        f", without {listed([shown_name(o) for o in sources.left_out])}, which can do harm" if sources.left_out else ""
    )
    return f"{reason}; compiled here from {sources.origin}{without}"


def _without_library(archive: Archive, unusable: str) -> RequestError:
    """Why an FMU that has no sources cannot run on this platform."""
    place, where = _place(archive), archive.where
    if unusable:
        return _no_library(f"{where}, {place}", unusable)
    folder, name = posixpath.split(place)
    suffix = posixpath.splitext(name)[1]
    others = [n.rpartition("/")[2] for n in sorted(archive.files) if posixpath.dirname(n) == folder]
    if others := [n for n in others if n.endswith(suffix)]:
        found = f"no {name} in {folder}, but {listed(others)}"
        valid = f"a library that has the name of the modelIdentifier, `{archive.interface_type.modelIdentifier}`"
        return refuse(where, found, valid, "Have its maker correct the name of the library or the modelIdentifier.")
    folders = [f"{in_words(folder)} ({folder})" for folder in platforms(archive)]
    found = f"binaries for {' and '.join(folders)} only, and no sources" if folders else "no binary and no sources"
    here = in_words(folder.rpartition("/")[2])
    remedy = f"Ask its maker to export it with a binary for {here}, or with its sources."
    return refuse(where, found, f"a binary for {platform_tuple()} ({place}), or the sources inside", remedy)


def _no_library(where: str, found: str) -> RequestError:
    remedy = _GIT_LFS if found == GIT_LFS_POINTER else "Ask its maker for a binary for this platform, or the sources."
    return refuse(where, found, f"a shared library for {platform_tuple()}", remedy)


def _function_remarks(archive: Archive, exports: frozenset[str], lenient: bool) -> list[str]:  # noqa: FBT001
    """Remarks on the functions of a library that has not been loaded. Raises `RequestError`."""
    where, version = f"{archive.where}, {archive.library}", archive.version
    prefix = _prefix(archive, exports)
    missing = missing_functions(archive, exports)
    _refuse_incomplete(archive, missing, where)
    expected = f"{archive.interface_type.modelIdentifier}_" if version == Version.FMI1 else ""
    surprising = f"{archive.library}: the names of its functions begin with `{prefix}`" if prefix else ""
    remarks = [surprising] if surprising and prefix != expected else []
    if not missing:
        return remarks
    if version != Version.FMI3 and not lenient:
        raise refuse(
            where, f"a library without {listed(missing, _LISTED)}", f"all functions of FMI {version}.0", _OVERLOOK
        )
    some = f"{len(missing)} functions" if len(missing) > 1 else "a function"
    return [*remarks, f"{archive.library}: lacks {some} of FMI {version}.0 that no run calls ({listed(missing)})"]


def missing_functions(archive: Archive, exports: frozenset[str]) -> list[str]:
    """The functions of FMI that are not among those that a library exports, with or without a prefix."""
    prefix = _prefix(archive, exports)
    return [n for n in all_functions(archive) if not {n, f"{prefix}{n}"} & exports]


def _prefix(archive: Archive, exports: frozenset[str]) -> str:
    return function_prefix(exports, archive.interface_type.modelIdentifier, known_function(archive.version))


def _refuse_incomplete(archive: Archive, missing: Collection[str], where: str) -> None:
    needed = needed_functions(archive)
    if lacking := [name for name in missing if name in needed]:
        found = f"a library without {listed(lacking, _LISTED)}"
        raise refuse(where, found, f"all functions of FMI {archive.version}.0", "Export the FMU again.")


def loaded(fmu_class: Any, archive: Archive, folder: Path, name: str) -> Any:
    """FMPy's object for an FMU, with the library loaded.

    Args:
        fmu_class: FMPy's class for the version of FMI and the interface type.
        archive: The FMU.
        folder: The folder in which it is unpacked.
        name: The instance name.

    Raises:
        RequestError: The library cannot be compiled or loaded, or lacks functions of FMI.
    """
    path = archive.library or _place(archive)
    library, where, code = folder / path, f"{archive.where}, {path}", archive.code
    if archive.library is None and (path in archive.files or not library.is_file()):  # what is there may be of no use
        library.parent.mkdir(parents=True, exist_ok=True)
        compile_library(archive, folder, library)
        code = machine_code(library.read_bytes())
    if code.problem:
        raise _no_library(where, code.problem)
    opened = _opened(library, code, where)
    try:
        identifier = archive.interface_type.modelIdentifier
        prefix = function_prefix(code.exports or (), identifier, known_function(archive.version))
        if archive.library is None or code.exports is None:  # otherwise it was known when the file was read
            names = all_functions(archive)
            found = [name for name in names if hasattr(opened, name) or hasattr(opened, f"{prefix}{name}")]
            _refuse_incomplete(archive, {*names} - {*found}, where)
        functions = FunctionLibrary(opened, prefix, FMICallException)
        return fmu_class(functions, archive.description.guid, identifier, str(folder), name)
    except BaseException:
        freeLibrary(opened._handle)  # noqa: SLF001 - ctypes has no public name for it
        raise


def compile_beforehand(archive: Archive, progress: Progress = SILENT) -> None:
    """Compile the library of an FMU that has only its sources, so that it is found in the user's cache from now on.

    Args:
        archive: The FMU.
        progress: Is told before the compiler is called.

    Raises:
        RequestError: The library cannot be compiled.
    """
    if archive.library is not None or kept_for(archive).is_file():
        return
    with scratch_folder("library") as temporary:
        folder = Path(temporary).resolve()
        unpack(archive.path, folder, archive.where, VALID_FMU)
        library = folder / _place(archive)
        library.parent.mkdir(parents=True, exist_ok=True)
        compile_library(archive, folder, library, progress)


def _opened(library: Path, code: MachineCode, where: str) -> ctypes.CDLL:
    at = Path.cwd()
    os.chdir(library.parent)  # so that libraries in the same folder are found, as in FMPy
    try:
        return ctypes.CDLL(str(library))
    except OSError as error:
        reason = str(error).replace(f"{library.parent}{os.sep}", "")
        found, remedy = not_loaded(reason, code.needed, [file.name for file in library.parent.iterdir()])
        raise refuse(where, found, f"a shared library that {platform_tuple()} loads", remedy) from None
    finally:
        os.chdir(at)
