"""The content of an FMU: all files by their paths."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from components.interfaces.block import Block
from components.interfaces.maths import Array
from fmus.export.c_sources import build_description, compiled_files, runtime_sources
from fmus.export.codegen import equations_source, variables_source
from fmus.export.dependencies import Dependencies, dependencies
from fmus.export.documentation import documentation
from fmus.export.fmi_variables import FmiVariables, fmi_variables_of
from fmus.export.model_description_fmi2 import model_description_fmi2
from fmus.export.model_description_fmi3 import model_description_fmi3
from fmus.export.terminals import terminals_and_icons
from fmus.lowering import lower
from fmus.toolchain.archives import BUILD_DESCRIPTION, MODEL_DESCRIPTION
from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import WRITTEN_VERSIONS, Version

_NAMESPACE: Final = uuid.UUID("7d1c4a9e-6a55-5e0c-9b6e-3f1a8c0f2d47")
"""The namespace of the tokens, in which the name of a token is the digest of an FMU's C sources."""


@dataclass(frozen=True)
class Generated:
    """What is generated from a block and its start values; it is the same for both versions of FMI."""

    variables: FmiVariables
    depends: Dependencies
    token: str
    """GUID (FMI 2.0) and instantiation token (FMI 3.0): the same C with the same start values has the same token."""
    sources: Mapping[str, bytes]
    """The generated C files by name."""


def generate(block: type[Block[Any, Any, Any]], start: Array) -> Generated:
    """Generate the C of a block.

    Args:
        block: The block.
        start: Start values of the parameters, one column in the order of `block.parameters()`.
    """
    lowered = lower(block)
    variables = fmi_variables_of(block, sampled=lowered.sampled, start=start)
    equations = equations_source(lowered)
    token = _token(equations, variables_source(variables, token=""))
    sources = {"model.c": equations.encode(), "variables.c": variables_source(variables, token).encode()}
    return Generated(variables, dependencies(lowered, variables), token, sources)


def content(generated: Generated, version: Version, binary: bytes) -> dict[str, bytes]:
    """All files of an FMU by their paths in the archive.

    Args:
        generated: What was generated from the block.
        version: The version of FMI.
        binary: The shared library for this platform.
    """
    name = generated.variables.block.name
    files = {
        binary_path(version, name): binary,
        "documentation/index.html": documentation(generated.variables, version),
        **{f"sources/{file}": text for file, text in generated.sources.items()},
        **{f"sources/{file}": text for file, text in runtime_sources(version).items()},
    }
    if version is Version.FMI2:
        files[MODEL_DESCRIPTION] = model_description_fmi2(generated.depends, generated.token, compiled_files(version))
    else:
        files[MODEL_DESCRIPTION] = model_description_fmi3(generated.depends, generated.token)
        files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_and_icons(generated.variables)
        files[BUILD_DESCRIPTION] = build_description(name)
    return files


def _token(*generated: str) -> str:
    digest = hashlib.sha256()
    for text in generated:
        digest.update(text.encode() + b"\0")
    for version in WRITTEN_VERSIONS:
        for name, source in runtime_sources(version).items():
            digest.update(name.encode() + b"\0" + source + b"\0")
    return str(uuid.uuid5(_NAMESPACE, digest.hexdigest()))
