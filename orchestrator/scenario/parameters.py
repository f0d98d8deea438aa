"""Parameter files: each value with its unit of measurement and its source, checked as it is read."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict

from orchestrator.system.files import Given, checked, read_toml

_FOLDERS: Final = (
    *Path(str(files("components"))).glob("*/parameters"),
    Path(__file__).parents[1] / "scenarios" / "parameters",
)
PARAMETERS: Final = {path.stem: path for folder in _FOLDERS for path in folder.glob("*.toml")}
"""Every parameter set by its name; they lie beside the blocks that they belong to."""


class _Set(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    values: dict[str, Given]


def parameter_set(name: str) -> dict[str, Given]:
    """A parameter file and all the files it uses; its own values win."""
    path = PARAMETERS[name]
    content = read_toml(path)
    found: dict[str, Given] = {}
    for used in content.pop("use", []):
        found.update(parameter_set(used))
    found.update(checked(_Set, {"values": content}, path.name).values)
    return found


def block_parameters(name: str) -> dict[str, Given]:
    """The parameter set of a block; a block that a program has added has none, and every value is a scenario's."""
    return parameter_set(name) if name in PARAMETERS else {}
