"""The shared library of an FMU: found for this platform, or compiled; loaded, and asked for what FMI needs of it."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import Any

from components.interfaces.problem import choices, refuse
from fmus.reading.archive import Archive
from fmus.reading.recompile import compile_library, has_sources
from fmus.toolchain.fmpy_library import freeLibrary, required_functions
from fmus.toolchain.platform_names import binary_path, platform_tuple
from fmus.toolchain.version import Version

_LISTED = 5


def binary_remark(archive: Archive) -> str | None:
    """What is to be said of the library before it is loaded. Raises `RequestError` when there can be none."""
    if binary(archive):
        return None
    if has_sources(archive):
        return f"no binary for {platform_tuple()}; compiled here from the sources inside"
    found = f"no binary for {platform_tuple()} ({_place(archive)}), and no sources to compile"
    valid = "a binary for this platform, or the sources inside"
    folders = platforms(archive)
    remedy = f"It has binaries for {choices(folders)}." if folders else "Compile the FMU for this platform."
    raise refuse(str(archive.path), found, valid, remedy)


def binary(archive: Archive) -> str | None:
    """The file in the FMU that is its library here; some FMI 2.0 files use the platform names of FMI 3.0."""
    paths = [_place(archive), binary_path(Version.FMI3, archive.kind.modelIdentifier)]
    return next((path for path in paths if path in archive.files), None)


def _place(archive: Archive) -> str:
    """Where the library has to be by the rules of FMI."""
    return binary_path(archive.version, archive.kind.modelIdentifier)


def platforms(archive: Archive) -> list[str]:
    """The platforms that the FMU has binaries for, by the names of their folders."""
    return sorted({n.split("/")[1] for n in archive.files if n.startswith("binaries/") and n.count("/") > 1})


def loaded(kind: Any, archive: Archive, folder: Path, name: str) -> Any:
    """FMPy's object for the FMU that is unpacked in `folder`. Raises `RequestError` when its library is of no use."""
    found = binary(archive)
    path = found or _place(archive)
    library, where = folder / path, f"{archive.path}, {path}"
    if found is None:
        library.parent.mkdir(parents=True, exist_ok=True)
        compile_library(archive, folder, library)
    opened = _opened(library, where)
    try:
        _refuse_incomplete(opened, kind, archive.version, where)
        return kind(  # FMPy knows where FMI 3.0 has its libraries, and takes no other place
            guid=archive.description.guid,
            modelIdentifier=archive.kind.modelIdentifier,
            unzipDirectory=str(folder),
            instanceName=name,
            **({"libraryPath": str(library)} if archive.version == Version.FMI2 else {}),
        )
    finally:
        freeLibrary(opened._handle)  # noqa: SLF001 - FMPy has opened it once more, and closes only that


def _opened(library: Path, where: str) -> ctypes.CDLL:
    at = Path.cwd()
    os.chdir(library.parent)  # libraries that come along are found from here, as FMPy does it
    try:
        return ctypes.CDLL(str(library))
    except OSError as error:
        said = str(error).replace(f"{library.parent}{os.sep}", "")
        found = f"a library that cannot be loaded ({said})"
        raise refuse(
            where, found, f"a shared library for {platform_tuple()}", "Compile it for this platform."
        ) from None
    finally:
        os.chdir(at)


def _refuse_incomplete(opened: ctypes.CDLL, kind: Any, version: Version, where: str) -> None:
    missing = [name for name in required_functions(kind, version) if not hasattr(opened, name)]
    if missing:
        rest = f" and {len(missing) - _LISTED} more" if len(missing) > _LISTED else ""
        found = f"a library without {', '.join(missing[:_LISTED])}{rest}"
        raise refuse(where, found, f"all functions of FMI {version}.0", "Export the FMU again.")
