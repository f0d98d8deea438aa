"""FMUs from Modelica files."""

from __future__ import annotations

import re
from pathlib import Path

from fmus.export.build import Built, build
from fmus.modelica.block import ModelicaBlock, modelica_block
from fmus.toolchain.version import Version

_REQUEST = re.compile(r"(?P<file>.+\.mo)(?::(?P<model>[\w.]+))?")


def is_modelica(request: str) -> bool:
    """Whether a request names a Modelica file: `FILE.mo`, or `FILE.mo:MODEL` for one of several models."""
    return _REQUEST.fullmatch(request) is not None


def file_of(request: str) -> Path:
    """The file that a request names: a Modelica file without the model, or any other request as it is."""
    match = _REQUEST.fullmatch(request)
    return Path(match["file"] if match else request)


def build_modelica(request: str, version: Version, folder: Path) -> Built:
    """Build the FMU of a Modelica model, as `build` does.

    Args:
        request: The file, or the file and the model, as `is_modelica` accepts them.
        version: The version of FMI.
        folder: The folder of all FMUs.

    Raises:
        RequestError: The model cannot become a block, or has parameters without a value.
        BuildError: The C compiler fails.
    """
    model = read_modelica(request)
    return build(model.block, version, model.start, folder)


def read_modelica(request: str, socket: str | None = None) -> ModelicaBlock:
    """The block of a Modelica model that is requested as for `build_modelica`, for a socket if it fits it.

    Args:
        request: The file, or the file and the model.
        socket: The name of the socket; None for the first that the model fits.

    Raises:
        RequestError: The model cannot become a block.
    """
    match = _REQUEST.fullmatch(request)
    assert match is not None, request  # noqa: S101 - the caller asks `is_modelica` first
    return modelica_block(Path(match["file"]), match["model"], socket)
