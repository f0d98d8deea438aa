"""FMUs from Modelica files."""

from __future__ import annotations

import re
from pathlib import Path

from fmus.export.build import Built, build
from fmus.modelica.block import modelica_block
from fmus.toolchain.version import Version

_REQUEST = re.compile(r"(?P<file>.+\.mo)(?::(?P<model>[\w.]+))?")


def is_modelica(request: str) -> bool:
    """Whether a request names a Modelica file: `FILE.mo`, or `FILE.mo:MODEL` for one of several models."""
    return _REQUEST.fullmatch(request) is not None


def build_modelica(request: str, version: Version, folder: Path, socket: str | None = None) -> Built:
    """Build the FMU of a Modelica model as `build` does; `socket` is what it has to fit, any if not given.

    Raises `RequestError` for a model that cannot become a block, or one with parameters that have no value.
    """
    match = _REQUEST.fullmatch(request)
    assert match is not None, request  # noqa: S101 - the caller asks `is_modelica` first
    made = modelica_block(Path(match["file"]), match["model"], socket)
    return build(made.block, version, made.start, folder)
