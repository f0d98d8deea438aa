"""FMUs and SSPs as ZIP archives: where files stand in an FMU, and archives whose bytes depend on their content only."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from components.interfaces.problem import RequestError, refuse

MODEL_DESCRIPTION: Final = "modelDescription.xml"
BUILD_DESCRIPTION: Final = "sources/buildDescription.xml"
"""Which sources an FMI 3.0 FMU is compiled from, and how."""

_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
"""The earliest time a ZIP archive can hold."""
_FILE_MODE: Final = 0o100644
_BINARY_MODE: Final = 0o100755
_UNIX: Final = 3
"""The code of the operating system whose file modes an entry has."""


def write_archive(path: Path, content: Mapping[str, bytes]) -> None:
    """Write an archive, which has its name only when it is complete.

    Args:
        path: The file to be written.
        content: The content of each file by its path in the archive.

    Raises:
        RequestError: The folder cannot be written to.
    """
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
            partial = Path(file.name)
            try:
                _write(file.file, content)
            except BaseException:
                partial.unlink()
                raise
        partial.chmod(0o644)
        partial.replace(path)
    except OSError as error:
        raise unwritable(path.parent, error) from error


def writable_folder(folder: Path) -> None:
    """Make a folder and check that it can be written to.

    Raises:
        RequestError: The folder cannot be made, or not be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise unwritable(folder, error) from error


def unwritable(folder: Path, error: OSError) -> RequestError:
    """The error for a folder that cannot be written to."""
    found = f"a folder that cannot be written to ({error.strerror})"
    return refuse(str(folder), found, "a writable folder", "Name another one.")


def _write(file: object, content: Mapping[str, bytes]) -> None:
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:  # pyright: ignore[reportArgumentType, reportCallIssue]
        for name in sorted(content):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = _UNIX
            entry.external_attr = (_BINARY_MODE if name.startswith("binaries/") else _FILE_MODE) << 16
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
            archive.writestr(entry, content[name])
