"""The names that FMI has for this platform, and for the path of a binary for it."""

from __future__ import annotations

import platform
import sys

from fmus.toolchain.version import Version

_PROCESSORS = {"amd64": "x86_64", "i386": "x86", "i686": "x86", "arm64": "aarch64"}
_SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "windows", "cygwin": "windows"}
_SUFFIXES = {"linux": ".so", "darwin": ".dylib", "windows": ".dll"}
_FMI2_FOLDERS = {
    "x86_64-linux": "linux64",
    "x86-linux": "linux32",
    "x86_64-darwin": "darwin64",
    "aarch64-darwin": "darwin64",
    "x86_64-windows": "win64",
    "x86-windows": "win32",
}

_SYSTEMS_IN_WORDS = {"linux": "Linux", "darwin": "macOS", "windows": "Windows"}
_PROCESSORS_IN_WORDS = {"x86_64": "64 bit", "x86": "32 bit", "aarch64": "ARM, 64 bit"}


def platform_tuple() -> str:
    """The platform tuple of FMI 3.0, for example `x86_64-linux`."""
    processor = platform.machine().lower()
    return f"{_PROCESSORS.get(processor, processor)}-{_system()}"


def binary_path(version: Version, identifier: str) -> str:
    """The path of the binary for this platform in an FMU.

    Args:
        version: The version of FMI.
        identifier: The model identifier.
    """
    known = platform_tuple()
    folder = known if version is Version.FMI3 else _FMI2_FOLDERS.get(known, known)
    return f"binaries/{folder}/{identifier}{_SUFFIXES.get(_system(), '.so')}"


def in_words(folder: str) -> str:
    """What the name of a folder with binaries means, such as `Windows, 64 bit`; the name itself where it is unknown."""
    known = next((name for name, of_fmi2 in _FMI2_FOLDERS.items() if of_fmi2 == folder), folder)
    processor, _, system = known.partition("-")
    if system not in _SYSTEMS_IN_WORDS:
        return folder
    return f"{_SYSTEMS_IN_WORDS[system]}, {_PROCESSORS_IN_WORDS.get(processor, processor)}"


def _system() -> str:
    return _SYSTEMS.get(sys.platform, sys.platform)
