"""The shared library of an FMU: found or compiled for this platform, loaded, and checked for the functions of FMI."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import choices, refuse
from fmus.reading.archive import Archive
from fmus.reading.recompile import compile_library, has_sources
from fmus.toolchain.fmpy_library import freeLibrary, required_functions
from fmus.toolchain.platform_names import binary_path, platform_tuple
from fmus.toolchain.version import Version

_LISTED: Final = 5
"""The number of missing functions that a message lists."""


def binary_remark(archive: Archive) -> str | None:
    """A remark for the user on the library, before it is loaded.

    Returns:
        The remark; None for an FMU with a binary for this platform.

    Raises:
        RequestError: There is neither a binary for this platform, nor are there sources to compile.
    """
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
    """The path of the library for this platform in the FMU; some FMI 2.0 FMUs use the platform names of FMI 3.0."""
    paths = [_place(archive), binary_path(Version.FMI3, archive.interface_type.modelIdentifier)]
    return next((path for path in paths if path in archive.files), None)


def _place(archive: Archive) -> str:
    """The path that FMI prescribes for the library."""
    return binary_path(archive.version, archive.interface_type.modelIdentifier)


def platforms(archive: Archive) -> list[str]:
    """The platforms for which the FMU has binaries, by the names of their folders."""
    return sorted({n.split("/")[1] for n in archive.files if n.startswith("binaries/") and n.count("/") > 1})


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
    existing = binary(archive)
    path = existing or _place(archive)
    library, where = folder / path, f"{archive.path}, {path}"
    if existing is None:
        library.parent.mkdir(parents=True, exist_ok=True)
        compile_library(archive, folder, library)
    opened = _opened(library, where)
    try:
        _refuse_incomplete(opened, fmu_class, archive.version, where)
        return fmu_class(  # for FMI 3.0, FMPy takes no path of the library
            guid=archive.description.guid,
            modelIdentifier=archive.interface_type.modelIdentifier,
            unzipDirectory=str(folder),
            instanceName=name,
            **({"libraryPath": str(library)} if archive.version == Version.FMI2 else {}),
        )
    finally:
        freeLibrary(opened._handle)  # noqa: SLF001 - FMPy has opened the library once more, and closes it only once


def _opened(library: Path, where: str) -> ctypes.CDLL:
    at = Path.cwd()
    os.chdir(library.parent)  # so that libraries in the same folder are found, as in FMPy
    try:
        return ctypes.CDLL(str(library))
    except OSError as error:
        reason = str(error).replace(f"{library.parent}{os.sep}", "")
        found = f"a library that cannot be loaded ({reason})"
        raise refuse(
            where, found, f"a shared library for {platform_tuple()}", "Compile it for this platform."
        ) from None
    finally:
        os.chdir(at)


def _refuse_incomplete(opened: ctypes.CDLL, fmu_class: Any, version: Version, where: str) -> None:
    missing = [name for name in required_functions(fmu_class, version) if not hasattr(opened, name)]
    if missing:
        rest = f" and {len(missing) - _LISTED} more" if len(missing) > _LISTED else ""
        found = f"a library without {', '.join(missing[:_LISTED])}{rest}"
        raise refuse(where, found, f"all functions of FMI {version}.0", "Export the FMU again.")
