"""The blocks of the catalogue by name, and the FMUs that are built from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from components import BLOCKS, EXTRAS
from components.interfaces.block import Block
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.progress import Progress
from fmus.export.build import build_all
from fmus.export.own_builds import built_folder
from fmus.modelica.build_modelica import build_modelica, is_modelica
from fmus.toolchain.version import Version
from orchestrator.scenario.parameters import PARAMETERS, block_parameters
from orchestrator.scenario.resolution import resolve

__all__ = ["block_named", "build_models", "built_folder", "default_values", "ensure_built"]


def block_named(name: str, where: str, socket: str | None = None) -> type[Block[Any, Any, Any]]:
    """Look a block up in the catalogue.

    Args:
        name: The name of the block.
        where: The place of the request, for messages.
        socket: The name of the socket that the block has to fit; any socket if not given.

    Returns:
        The class of the block.

    Raises:
        RequestError: There is no such block, its extra is not installed, or it fits another socket.
    """
    fitting = [n for n, block in BLOCKS.items() if socket in (None, block.socket.name)]
    if name in EXTRAS and name not in BLOCKS:
        raise refuse(where, f"`{name}` without its extra", choices(fitting), f"Install macrostep[{EXTRAS[name]}].")
    if name not in BLOCKS:
        remedy = did_you_mean(name, fitting) or "A file ends in .fmu or .mo."
        raise refuse(where, f"the unknown block `{name}`", choices(fitting), remedy)
    if name not in fitting:
        raise refuse(where, f"`{name}`, a block of the socket `{BLOCKS[name].socket.name}`", choices(fitting))
    return BLOCKS[name]


def default_values(block: type[Block[Any, Any, Any]]) -> dict[str, Any]:
    """The values of a block's own parameter set, which are the start values of its FMU. Raises `RequestError`."""
    resolved = resolve(block.name, block.parameters(), block_parameters(block.name))
    raise_if_any(resolved.problems)
    return resolved.values


def ensure_built(
    blocks: Sequence[type[Block[Any, Any, Any]]],
    versions: Sequence[Version],
    folder: Path,
    progress: Progress,
    values: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
) -> dict[tuple[str, Version], Path]:
    """Build the FMUs that are missing or out of date.

    Args:
        blocks: The blocks.
        versions: The versions of FMI.
        folder: The folder of all FMUs.
        progress: Receives a report on each FMU that is built.
        values: The start values of blocks without a parameter set, by the name of the block.

    Returns:
        The FMU file by the name of the block and the version of FMI.

    Raises:
        RequestError: A start value is wrong, the folder cannot be written to, or there is no compiler.
        BuildError: The compiler fails.
    """
    starts = {b: default_values(b) if b.name in PARAMETERS else values.get(b.name, {}) for b in blocks}
    requests = [(block, version, starts[block]) for block in blocks for version in versions]
    built = build_all(requests, folder, progress)
    return {(block.name, version): b.path for (block, version, _), b in zip(requests, built, strict=True)}


def build_models(requests: Sequence[str], versions: Sequence[Version], folder: Path, progress: Progress) -> list[Path]:
    """Build the FMUs of Modelica files.

    Args:
        requests: `FILE.mo`, or `FILE.mo:MODEL`.
        versions: The versions of FMI.
        folder: The folder of all FMUs.
        progress: Receives a report on each file.

    Returns:
        The files of the FMUs: for each request, one of each version.

    Raises:
        RequestError: A request does not name a Modelica file, or its model cannot become a block.
        BuildError: The compiler fails.
    """
    valid = "a Modelica file: FILE.mo, or FILE.mo:MODEL"
    raise_if_any(Problem("macrostep build", f"`{r}`", valid) for r in requests if not is_modelica(r))
    paths: list[Path] = []
    for request in requests:
        progress.now(f"building {request}")
        paths += [build_modelica(request, version, folder).path for version in versions]
    return paths
