"""The parameter sets beside the blocks, read without anything of the orchestrator."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import components
from components import BLOCKS

SETS = {path.stem: path for path in sorted(Path(components.__file__).parent.glob("*/parameters/*.toml"))}


def set_values(name: str) -> dict[str, Any]:
    """The numbers of a parameter set and of the sets that it uses; its own win."""
    content = tomllib.loads(SETS[name].read_text(encoding="utf-8"))
    used = {k: v for other in content.pop("use", []) for k, v in set_values(other).items()}
    return used | {k: entry["value"] for k, entry in content.items()}


def block_values(name: str) -> dict[str, Any]:
    """The values of a block's parameters in its default parameter set."""
    values = set_values(name)
    return {v.name: values[v.name] for v in BLOCKS[name].parameters()}
