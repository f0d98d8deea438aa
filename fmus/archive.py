"""Opening an FMU: what it says it is, checked before anything of it runs."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import read_model_description
from fmpy.model_description import ModelDescription, ModelVariable
from lxml import etree

from components.interfaces.problem import refuse
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from fmus.unit import Interface
from fmus.version import Version

_TYPES = {
    "Real": Type.FLOAT64,
    "Float64": Type.FLOAT64,
    "Integer": Type.INT32,
    "Int32": Type.INT32,
    "Boolean": Type.BOOLEAN,
    "Enumeration": Type.ENUMERATION,
}
_ELEMENT = re.compile(r"(?P<name>.+)\[(?P<index>\d+(?:,\d+)*)\]")


@dataclass(frozen=True)
class Archive:
    """An FMU file that has been read and understood."""

    path: Path
    version: Version
    description: Any
    interface: Interface
    references: dict[str, list[int]]
    """Value references of each variable: one per element in FMI 2.0, one in all in FMI 3.0"""


def open_fmu(path: Path) -> Archive:
    """Read an FMU's description. Raises `RequestError` when it is none, or none that can run here."""
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
    interface, references = _interface(root, description, version)
    return Archive(path, version, description, interface, references)


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


def _interface(root: Any, description: ModelDescription, version: Version) -> tuple[Interface, dict[str, list[int]]]:
    chosen: dict[str, list[tuple[Variable, Any, list[int]]]] = {"input": [], "output": [], "parameter": []}
    for causality, group in chosen.items():
        scalars = [v for v in description.modelVariables if v.causality == causality and v.type in _TYPES]
        group.extend(_arrays(scalars) if version == Version.FMI2 else map(_variable, scalars))
    inputs, outputs, parameters = ([v for v, _, _ in group] for group in chosen.values())
    interface = Interface(
        kind=str(description.modelName),
        inputs=tuple(inputs),
        outputs=tuple(outputs),
        parameters=tuple(parameters),
        feedthrough=_feedthrough(description, outputs, inputs),
        output_after_set=_output_after_set(root),
        starts={v.name: start for group in chosen.values() for v, start, _ in group if start is not None},
    )
    return interface, {v.name: refs for group in chosen.values() for v, _, refs in group}


def _quantity(variable: Any, shape: tuple[int, ...]) -> Quantity:
    unit = variable.unit or (variable.declaredType.unit if variable.declaredType else None) or "1"
    low, high = (None if b is None else float(b) for b in (variable.min, variable.max))
    items = variable.declaredType.items if variable.declaredType else []
    enumeration: Any = IntEnum(variable.declaredType.name, {i.name: int(i.value) for i in items}) if items else None
    kind = _TYPES[str(variable.type)]
    if kind is Type.ENUMERATION:
        low = high = None
    return Quantity(unit, variable.description or variable.name, kind, shape, low, high, enumeration)


def _variable(variable: Any) -> tuple[Variable, Any, list[int]]:
    shape = tuple(int(n) for n in variable.shape or ())
    quantity = _quantity(variable, shape)
    start = None if variable.start is None else [_value(text, quantity.type) for text in str(variable.start).split()]
    value = None if start is None else (np.resize(start, shape) if shape else start[0])
    return Variable(variable.name, quantity), value, [variable.valueReference]


def _value(text: str, kind: Type) -> float | int | bool:
    if kind is Type.BOOLEAN:
        return text in {"true", "1", "True"}
    return float(text) if kind is Type.FLOAT64 else int(text)


def _arrays(scalars: Iterable[ModelVariable]) -> list[tuple[Variable, Any, list[int]]]:
    """FMI 2.0 elements `name[1]`, `name[2]`, ... as arrays again; what does not fill its shape stays scalar."""
    grouped: dict[str, list[tuple[tuple[int, ...], ModelVariable]]] = {}
    for scalar in scalars:
        match = _ELEMENT.fullmatch(scalar.name)
        name = match["name"] if match else scalar.name
        index = tuple(int(i) for i in match["index"].split(",")) if match else ()
        grouped.setdefault(name, []).append((index, scalar))
    found: list[tuple[Variable, Any, list[int]]] = []
    for name, elements in grouped.items():
        shape = tuple(max(index[axis] for index, _ in elements) for axis in range(len(elements[0][0])))
        wanted = [tuple(i + 1 for i in index) for index in np.ndindex(*shape)]
        if not shape or [index for index, _ in elements] != wanted:
            found.extend(_variable(scalar) for _, scalar in elements)
            continue
        parts = [_variable(scalar) for _, scalar in elements]
        starts = None if any(s is None for _, s, _ in parts) else np.reshape([s for _, s, _ in parts], shape)
        quantity = _quantity(elements[0][1], shape)
        found.append((Variable(name, quantity), starts, [ref for _, _, refs in parts for ref in refs]))
    return found


def _feedthrough(description: ModelDescription, outputs: list[Variable], inputs: list[Variable]) -> Any:
    """From the model structure; an output without declared dependencies is taken to depend on every input."""
    column = {v.name: i for i, v in enumerate(inputs)}
    row = {v.name: i for i, v in enumerate(outputs)}
    found = np.zeros((len(outputs), len(inputs)), dtype=bool)
    listed: set[str] = set()
    for unknown in description.outputs:
        name = _whole(unknown.variable.name, row) if unknown.variable else None
        if name is None:
            continue
        listed.add(name)
        if unknown.dependencies is None:
            found[row[name], :] = True
        for source in unknown.dependencies or []:
            if (whole := _whole(source.name, column)) is not None:
                found[row[name], column[whole]] = True
    for name in row.keys() - listed:
        found[row[name], :] = True
    return found


def _whole(name: str, known: dict[str, int]) -> str | None:
    if name in known:
        return name
    match = _ELEMENT.fullmatch(name)
    return match["name"] if match and match["name"] in known else None


def _output_after_set(root: Any) -> bool:
    """Whether the FMU promises, by our vendor annotation, that its outputs follow its inputs before the step."""
    return bool(root.xpath("//*[local-name()='Outputs' and @afterSet='true']"))
