"""The C sources of an FMU, and the description by which an importer compiles them again."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Final

from lxml import etree

from fmus.export.description_parts import to_bytes
from fmus.toolchain.compiler import FLAGS
from fmus.toolchain.version import Version

GENERATED: Final = ("model.c", "variables.c")
_CORE: Final = ("instance.c", "core.c", "access.c", "snapshot.c")
_SHIMS: Final = MappingProxyType(
    {Version.FMI2: ("fmi2.c", "fmi2_absent.c"), Version.FMI3: ("fmi3.c", "events.c", "fmi3_events.c", "fmi3_absent.c")}
)
_OWN_HEADERS: Final = ("core.h", "model.h")
_FMI_HEADERS: Final = MappingProxyType(
    {
        Version.FMI2: ("fmi2FunctionTypes.h", "fmi2Functions.h", "fmi2TypesPlatform.h"),
        Version.FMI3: ("fmi3FunctionTypes.h", "fmi3Functions.h", "fmi3PlatformTypes.h"),
    }
)


def runtime_files(version: Version) -> tuple[str, ...]:
    """The C files of the runtime that are compiled into an FMU of this version of FMI."""
    return (*_CORE, *_SHIMS[version])


def compiled_files(version: Version) -> tuple[str, ...]:
    """All C files that are compiled into an FMU of this version of FMI, in the order of its build description."""
    return (*GENERATED, *runtime_files(version))


@cache
def runtime_sources(version: Version) -> MappingProxyType[str, bytes]:
    """The runtime's C files and headers by name, with the headers of FMI, in which each carries its licence."""
    from fmus.toolchain.fmpy_library import C_HEADERS  # noqa: PLC0415 - FMUs that are up to date need no FMPy

    own = files("fmus") / "runtime"
    sources = {name: (own / name).read_bytes() for name in (*runtime_files(version), *_OWN_HEADERS)}
    sources |= {name: (C_HEADERS / name).read_bytes() for name in _FMI_HEADERS[version]}
    return MappingProxyType(sources)


def build_description(identifier: str) -> bytes:
    """The buildDescription.xml of FMI 3.0.

    Args:
        identifier: The model identifier, which is the name of the library too.
    """
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = etree.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    file_set = etree.SubElement(configuration, "SourceFileSet", language="C99", compilerOptions=" ".join(FLAGS))
    for name in compiled_files(Version.FMI3):
        etree.SubElement(file_set, "SourceFile", name=name)
    etree.SubElement(
        configuration, "Library", name="m", external="true", description="mathematics; part of the C library on Windows"
    )
    return to_bytes(root)
