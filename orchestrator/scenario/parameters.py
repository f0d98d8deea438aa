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
"""The file of every parameter set, by the name of the set."""


class _Set(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    values: dict[str, Given]


def parameter_set(name: str) -> dict[str, Given]:
    """Read a parameter file and all files that it uses; its own values replace theirs.

    Args:
        name: The name of the parameter set, one of `PARAMETERS`.

    Raises:
        RequestError: A file cannot be read, or has wrong entries.
    """
    path = PARAMETERS[name]
    content = read_toml(path)
    values: dict[str, Given] = {}
    for used in content.pop("use", []):
        values.update(parameter_set(used))
    values.update(checked(_Set, {"values": content}, path.name).values)
    return values


def block_parameters(name: str) -> dict[str, Given]:
    """The parameter set of a block, by the block's name; empty for a block that was added by a program."""
    return parameter_set(name) if name in PARAMETERS else {}
