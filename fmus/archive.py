"""Opening an FMU: what it says it is, checked before anything of it runs."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from fmpy import read_model_description
from fmpy.model_description import ModelDescription
from lxml import etree

from components.interfaces.problem import refuse
from components.interfaces.record import Variable
from fmus.ports import Port, ports, whole_name
from fmus.unit import Interface
from fmus.version import Version


@dataclass(frozen=True)
class Archive:
    """An FMU file that has been read and understood."""

    path: Path
    version: Version
    description: Any
    interface: Interface
    references: dict[str, list[int]]
    """Value references of each variable: one per element in FMI 2.0, one in all in FMI 3.0"""
    structural: tuple[str, ...] = ()
    """Structural parameters: those that lengths of arrays depend on"""


def open_fmu(path: Path, values: Mapping[str, Any] = MappingProxyType({})) -> Archive:
    """Read an FMU's description. Raises `RequestError` when it is none, or none that can run here.

    `values` are those of its parameters that are given: the structural ones decide the lengths of arrays.
    """
    where = str(path)
    valid = "an FMU: a zip archive with modelDescription.xml, FMI 2.0 or 3.0 Co-Simulation"
    if not path.is_file():
        raise refuse(where, "no such file", valid, "Build the FMUs of this project with `macrostep build`.")
    if not zipfile.is_zipfile(path):
        raise refuse(where, "a file that is no zip archive", valid)
    root = _description_root(path, where, valid)
    version = _declared_version(root, where, valid)
    try:
        with path.open("rb") as file:  # given a path, FMPy leaves it open when it fails
            description = read_model_description(file)
    except Exception as error:  # FMPy raises bare Exception for whatever the schema refuses
        said = f"`{error}`, which is not there" if isinstance(error, KeyError) else str(error)
        raise refuse(where, f"a model description that breaks the standard ({said})", valid) from error
    if description.coSimulation is None:
        raise refuse(
            where, "no Co-Simulation interface", "an FMU for Co-Simulation", "Export it again for Co-Simulation."
        )
    found = ports(root, description, version, values)
    return Archive(
        path,
        version,
        description,
        _interface(root, description, found),
        references={p.variable.name: p.references for p in found},
        structural=tuple(p.variable.name for p in found if p.structural),
    )


def _description_root(path: Path, where: str, valid: str) -> Any:
    """The root element of the model description."""
    try:
        with zipfile.ZipFile(path) as archive:
            return etree.fromstring(archive.read("modelDescription.xml"), etree.XMLParser(resolve_entities=False))
    except (KeyError, OSError, zipfile.BadZipFile) as error:
        raise refuse(where, "an archive without a readable modelDescription.xml", valid) from error
    except etree.XMLSyntaxError as error:
        raise refuse(where, f"a modelDescription.xml that is not well-formed ({error})", valid) from error


def _declared_version(root: Any, where: str, valid: str) -> Version:
    """The version of FMI that the description names."""
    version = root.get("fmiVersion")
    if root.tag != "fmiModelDescription" or version is None:
        raise refuse(where, f"a modelDescription.xml that describes no FMU (its root is `{root.tag}`)", valid)
    if version.split(".")[0] not in {"2", "3"}:
        raise refuse(where, f"FMI version {version}", "2.0 or 3.0", "Export it again as FMI 2.0 or 3.0.")
    return Version(int(version.split(".")[0]))


def _interface(root: Any, description: ModelDescription, found: list[Port]) -> Interface:
    inputs, outputs, parameters = (
        [p.variable for p in found if p.causality == causality] for causality in ("input", "output", "parameter")
    )
    return Interface(
        kind=str(description.modelName),
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        parameters=tuple(parameters),
        feedthrough=_feedthrough(description, outputs, inputs),
        output_after_set=_output_after_set(root),
        starts={p.variable.name: p.start for p in found if p.start is not None},
        rolls_back=_rolls_back(description),
    )


def _feedthrough(description: ModelDescription, outputs: list[Variable], inputs: list[Variable]) -> Any:
    """From the model structure; an output without declared dependencies is taken to depend on every input."""
    column = {v.name: i for i, v in enumerate(inputs)}
    row = {v.name: i for i, v in enumerate(outputs)}
    found = np.zeros((len(outputs), len(inputs)), dtype=bool)
    listed: set[str] = set()
    for unknown in description.outputs:
        name = whole_name(unknown.variable.name, row) if unknown.variable else None
        if name is None:
            continue
        listed.add(name)
        if unknown.dependencies is None:
            found[row[name], :] = True
        for source in unknown.dependencies or []:
            if (whole := whole_name(source.name, column)) is not None:
                found[row[name], column[whole]] = True
    for name in row.keys() - listed:
        found[row[name], :] = True
    return found


def _rolls_back(description: ModelDescription) -> bool:
    return bool(description.coSimulation and description.coSimulation.canGetAndSetFMUstate)


def _output_after_set(root: Any) -> bool:
    """Whether the FMU promises, by our vendor annotation, that its outputs follow its inputs before the step."""
    return bool(root.xpath("//*[local-name()='Outputs' and @afterSet='true']"))
