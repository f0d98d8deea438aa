"""The XML schemas of SSP 1.0, which FMPy brings along."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import fmpy.ssp
from lxml import etree


def schema_folder() -> Path:
    """The folder with the schemas of SSP 1.0."""
    return Path(str(files(fmpy.ssp))) / "schema"


@cache
def schema(name: str) -> Any:
    """A schema by the name of its file (`SystemStructureDescription.xsd`), ready to validate."""
    return etree.XMLSchema(file=str(schema_folder() / name))
