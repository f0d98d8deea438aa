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


def build_modelica(request: str, version: Version, folder: Path, socket: str | None = None) -> Built:
    """Build the FMU of a Modelica model, as `build` does.

    Args:
        request: The file, or the file and the model, as `is_modelica` accepts them.
        version: The version of FMI.
        folder: The folder of all FMUs.
        socket: The name of the socket that the model is for; None for the one that it fits best.

    Raises:
        RequestError: The model cannot become a block, or has parameters without a value.
        BuildError: The C compiler fails.
    """
    model = read_modelica(request, socket)
    return build(model.block, version, model.start, folder)


def read_modelica(request: str, socket: str | None = None) -> ModelicaBlock:
    """The block of a Modelica model that is requested as for `build_modelica`. Raises `RequestError`."""
    match = _REQUEST.fullmatch(request)
    assert match is not None, request  # noqa: S101 - the caller asks `is_modelica` first
    return modelica_block(Path(match["file"]), match["model"], socket)
