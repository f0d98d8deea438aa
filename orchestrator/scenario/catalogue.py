"""The catalogue of blocks, and the FMUs that are built of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import fmus
from components import BLOCKS, EXTRAS
from components.interfaces.block import Block
from components.interfaces.problem import Problem, choices, did_you_mean, raise_if_any, refuse
from components.interfaces.progress import Progress
from fmus.export.build import build_all
from fmus.modelica.build_modelica import build_modelica, is_modelica
from fmus.toolchain.version import Version
from orchestrator.scenario.parameters import PARAMETERS, block_parameters
from orchestrator.scenario.resolution import resolve


def built_folder() -> Path:
    """Where built FMUs are: in the checkout, or in the user's cache when macrostep is installed."""
    package = Path(fmus.__file__).parent
    if (package.parent / "pyproject.toml").is_file():
        return package / "built"
    import platformdirs  # noqa: PLC0415 - only an installed macrostep needs it

    return platformdirs.user_cache_path("macrostep") / "built"


def block_named(name: str, where: str, socket: str | None = None) -> type[Block[Any, Any, Any]]:
    """A block of the catalogue, for a socket if one is named.

    Args:
        name: Name of the block.
        where: What asked for it, for the message.
        socket: Name of the socket that the block has to fit.

    Raises:
        RequestError: When there is no such block, its extra is not installed, or it fits another socket.
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
    """The numbers of a block's own parameter set: the start values of its FMU. Raises `RequestError`."""
    found = resolve(block.name, block.parameters(), block_parameters(block.name))
    raise_if_any(found.problems)
    return found.values


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
        folder: Where the FMUs are kept.
        progress: Called with a line of text for each FMU that is built.
        values: By name, the start values of blocks that have no parameter set.

    Returns:
        The FMU file of each block, by name, and version.
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
        folder: Where the FMUs are kept.
        progress: Called with a line of text for each file.

    Raises:
        RequestError: When a request does not name a Modelica file, or its model cannot become a block.
    """
    valid = "a Modelica file: FILE.mo, or FILE.mo:MODEL"
    raise_if_any(Problem("macrostep build", f"`{r}`", valid) for r in requests if not is_modelica(r))
    found: list[Path] = []
    for request in requests:
        progress.now(f"building {request}")
        found += [build_modelica(request, version, folder).path for version in versions]
    return found
