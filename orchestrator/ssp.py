"""System Structure and Parameterization (SSP): any system as one exchange file, and back.

A system of FMI 2.0 FMUs is written as SSP 1.0, element by element; with FMI 3.0 FMUs or blocks of this process it is
SSP 2.0, whose connectors have dimensions. What SSP has no word for (macro step, scene, sockets, held inputs) stands
in annotations of type `org.macrostep`, which other tools pass over.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final, TypeAlias, cast

import numpy as np
from lxml import etree

from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.unit_strings import UNITS
from fmus.version import Version
from orchestrator.scenario import Scenario
from orchestrator.system import Fmu, InProcess, System

SSD: Final = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC: Final = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV: Final = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
OURS: Final = "urn:macrostep"
BLOCK_TYPE: Final = "application/x-macrostep-block"
BLOCK_SOURCE: Final = "urn:macrostep:block:"
FMU_TYPE: Final = "application/x-fmu-sharedlibrary"
_NAMESPACES: Final = {"ssd": SSD, "ssc": SSC, "ssv": SSV}
_OLD_NAMES: Final = {Type.FLOAT64: "Real", Type.INT32: "Integer"}
Element: TypeAlias = Any
"""An element of lxml, whose own type is private"""
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)


def write(scenario: Scenario, path: Path) -> None:
    """Write a scenario's system with its FMUs and parameter values as one `.ssp` file; equal systems, equal bytes."""
    files: dict[str, bytes] = {"SystemStructure.ssd": _text(_description(scenario))}
    for name, source in scenario.system.units.items():
        files[f"resources/{name}.ssv"] = _text(_parameter_set(scenario, name))
        if isinstance(source, Fmu):
            files[f"resources/{Path(source.path).name}"] = Path(source.path).read_bytes()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.compress_type = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
            archive.writestr(info, files[name])


def _text(root: Element) -> bytes:
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def is_old(system: System) -> bool:
    """Whether SSP 1.0 can say everything: all units are FMI 2.0 FMUs."""
    return all(isinstance(s, Fmu) and s.archive.version == Version.FMI2 for s in system.units.values())


def _description(scenario: Scenario) -> Element:
    system, old = scenario.system, is_old(scenario.system)
    root = etree.Element(_q(SSD, "SystemStructureDescription"), nsmap=_NAMESPACES)
    root.set("version", "1.0" if old else "2.0")
    root.set("name", scenario.name)
    top = _add(root, SSD, "System", name=scenario.name, description=scenario.title)
    elements = _add(top, SSD, "Elements")
    quantities: list[Quantity] = []
    for name, source in system.units.items():
        quantities += _component(elements, name, source, old=old)
    wires = _add(top, SSD, "Connections")
    for wire in system.connections:
        variable = system.variable(f"{wire.unit}.{wire.input}", role="inputs")
        ends = zip(_names(wire.output, variable, old=old), _names(wire.input, variable, old=old), strict=True)
        for start, end in ends:
            _add(
                wires,
                SSD,
                "Connection",
                startElement=wire.source,
                startConnector=start,
                endElement=wire.unit,
                endConnector=end,
            )
    _enumerations(root, quantities)
    _units(root, quantities)
    _add(root, SSD, "DefaultExperiment", startTime="0", stopTime=repr(scenario.until))
    annotations = _add(root, SSD, "Annotations")
    annotation = _add(annotations, SSC, "Annotation", type="org.macrostep")
    _add(annotation, OURS, "Scenario").text = json.dumps(_extras(scenario))
    return root


def _extras(scenario: Scenario) -> dict[str, Any]:
    held = {path: np.asarray(value).tolist() for path, value in scenario.system.held.items()}
    return {
        "step": scenario.h,
        "scene": asdict(scenario.scene) if scenario.scene else None,  # type: ignore[call-overload]
        "sockets": {name: socket.name for name, socket in scenario.system.sockets.items()},
        "held": held,
        "sources": {path: s for path, s in scenario.sources.items() if path.startswith(("scene.", "experiment."))},
    }


def _component(parent: Element, name: str, source: Fmu | InProcess, *, old: bool) -> list[Quantity]:
    kind, where = FMU_TYPE, f"resources/{Path(source.path).name}" if isinstance(source, Fmu) else ""
    if isinstance(source, InProcess):
        kind, where = BLOCK_TYPE, BLOCK_SOURCE + source.block.name
    component = _add(parent, SSD, "Component", name=name, type=kind, source=where)
    connectors = _add(component, SSD, "Connectors")
    interface = source.interface
    groups = {"input": interface.inputs, "output": interface.outputs, "parameter": interface.parameters}
    for role, variables in groups.items():
        for variable in variables:
            for label in _names(variable.name, variable, old=old):
                connector = _add(connectors, SSD, "Connector", name=label, kind=role)
                _type(connector, SSC, variable.quantity, old=old)
                if not old:
                    _dimensions(connector, variable)
    bindings = _add(component, SSD, "ParameterBindings")
    _add(bindings, SSD, "ParameterBinding", source=f"resources/{name}.ssv")
    return [v.quantity for variables in groups.values() for v in variables]


def _names(name: str, variable: Variable, *, old: bool) -> list[str]:
    return Variable(name, variable.quantity).elements if old else [name]


def _type(parent: Element, space: str, q: Quantity, *, old: bool) -> Element:
    label = _OLD_NAMES.get(q.type, str(q.type)) if old else str(q.type)
    made = _add(parent, space, label)
    if q.type is Type.FLOAT64:
        made.set("unit", q.unit)
    if q.type is Type.ENUMERATION and q.enumeration is not None:
        made.set("name", q.enumeration.__name__)
    return made


def _dimensions(parent: Element, variable: Variable) -> None:
    for n in variable.quantity.shape:
        _add(parent, SSC, "Dimension", size=str(n))


def _parameter_set(scenario: Scenario, name: str) -> Element:
    source, old = scenario.system.units[name], is_old(scenario.system)
    root = etree.Element(_q(SSV, "ParameterSet"), nsmap={"ssv": SSV, "ssc": SSC})
    root.set("version", "1.0" if old else "2.0")
    root.set("name", name)
    parameters = _add(root, SSV, "Parameters")
    used: list[Quantity] = []
    for variable in source.interface.parameters:
        if variable.name not in source.parameters:
            continue
        used.append(variable.quantity)
        value = np.asarray(source.parameters[variable.name])
        origin = scenario.sources.get(f"{name}.{variable.name}", {}).get("source", "")
        for label, text in _values(variable, value, old=old):
            parameter = _add(parameters, SSV, "Parameter", name=label)
            if origin:
                parameter.set("description", str(origin))
            _type(parameter, SSV, variable.quantity, old=old).set("value", text)
            if not old:
                _dimensions(parameter, variable)
    _units(root, used, space=SSV)
    return root


def _values(variable: Variable, value: np.ndarray[Any, Any], *, old: bool) -> Iterator[tuple[str, str]]:
    texts = [_literal(element, variable.quantity) for element in value.ravel().tolist()]
    if old:
        yield from zip(variable.elements, texts, strict=True)
    else:
        yield variable.name, " ".join(texts)


def _literal(value: float | bool, q: Quantity) -> str:  # noqa: FBT001
    if q.type is Type.BOOLEAN:
        return "true" if value else "false"
    if q.enumeration is not None:
        return q.enumeration(int(value)).name
    return repr(float(value)) if q.type is Type.FLOAT64 else str(int(value))


def _enumerations(root: Element, quantities: list[Quantity]) -> None:
    kinds = {q.enumeration.__name__: q.enumeration for q in quantities if q.enumeration is not None}
    if not kinds:
        return
    parent = _add(root, SSD, "Enumerations")
    for name, kind in sorted(kinds.items()):
        enumeration = _add(parent, SSC, "Enumeration", name=name)
        for item in kind:
            _add(enumeration, SSC, "Item", name=item.name, value=str(item.value))


def _units(root: Element, quantities: list[Quantity], space: str = SSD) -> None:
    names = sorted({q.unit for q in quantities if q.type is Type.FLOAT64})
    if not names:
        return
    parent = _add(root, space, "Units")
    for name in names:
        unit = _add(parent, SSC, "Unit", name=name)
        exponents: Mapping[str, int] = UNITS.get(name, {})
        _add(unit, SSC, "BaseUnit", **{base: str(n) for base, n in exponents.items()})


def _add(parent: Element, space: str, label: str, /, **attributes: str) -> Element:
    return cast(Any, etree.SubElement)(parent, _q(space, label), attributes)


def _q(space: str, name: str) -> str:
    return f"{{{space}}}{name}"
