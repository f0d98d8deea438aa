"""Writing a system as one SSP file (System Structure and Parameterization), which `reader` reads back.

A system of FMI 2.0 FMUs is written as SSP 1.0, element by element, for other tools; with FMI 3.0 FMUs or blocks of this
process it is SSP 2.0, whose connectors have dimensions. What SSP has no word for (scene, sockets, held inputs) stands
in annotations of type `org.macrostep`, which other tools pass over. All parameter sets carry the scenario's name: Ecos
applies one set by its name to the whole system.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import numpy as np
from lxml import etree

from components.interfaces.conversion import IDENTITY, Linear, Transformation
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from fmus.toolchain.archives import write_archive
from fmus.toolchain.version import Version
from orchestrator.ssp.rules import BLOCK_TYPE, FMU_TYPE, MAPPING_TYPE, SSC, SSD, SSV, Node
from orchestrator.ssp.xml import add, add_enumerations, add_units, has_unit, literal, qualified
from orchestrator.system.experiment import Scenario
from orchestrator.system.source import UnitSource
from orchestrator.system.system import Connection, System

OURS: Final = "urn:macrostep"
OSP: Final = "http://opensimulationplatform.com/SSP/OSPAnnotations"
BLOCK_SOURCE: Final = "urn:macrostep:block:"
_NAMESPACES: Final = {"ssd": SSD, "ssc": SSC, "ssv": SSV, "osp": OSP}
_OLD_NAMES: Final = {Type.FLOAT64: "Real", Type.INT32: "Integer"}


def write(scenario: Scenario, path: Path) -> None:
    """Write a scenario's system with its FMUs and parameter values as one `.ssp` file; equal systems, equal bytes.

    Raises `RequestError` for a unit that SSP cannot carry, and for a folder that cannot be written to.
    """
    files: dict[str, bytes] = {"SystemStructure.ssd": _text(_description(scenario))}
    for name, source in scenario.system.units.items():
        files[f"resources/{name}.ssv"] = _text(_parameter_set(scenario, name))
        if (file := source.describe().file) is not None:
            resource = _resource(scenario.system, name, file)
            files[resource] = file.read_bytes()
            if (mapping := source.mapping_text(Path(resource).name)) is not None:
                files[_mapping_resource(name)] = mapping.encode()
    write_archive(path, files)


def _mapping_resource(unit: str) -> str:
    return f"resources/{unit}.toml"


def _resource(system: System, unit: str, path: Path) -> str:
    """Where a unit's FMU is in the archive; the unit's name comes first where another file has the same name."""
    files = {file for source in system.units.values() if (file := source.describe().file) is not None}
    shared = any(file.name == path.name for file in files - {path})
    return f"resources/{unit}.{path.name}" if shared else f"resources/{path.name}"


def _text(root: Node) -> bytes:
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def is_old(system: System) -> bool:
    """Whether SSP 1.0 can say everything: all units are FMI 2.0 FMUs."""
    return all(
        source.describe().version is Version.FMI2 and source.mapping_text() is None for source in system.units.values()
    )


def _description(scenario: Scenario) -> Node:
    system, old = scenario.system, is_old(scenario.system)
    root = etree.Element(qualified(SSD, "SystemStructureDescription"), nsmap=_NAMESPACES)
    root.set("version", "1.0" if old else "2.0")
    root.set("name", scenario.name)
    top = add(root, SSD, "System", name=scenario.name, description=scenario.title)
    elements = add(top, SSD, "Elements")
    quantities: list[Quantity] = []
    for name in system.units:
        quantities += _component(elements, scenario, name, old=old)
    wires = add(top, SSD, "Connections") if system.connections or system.clock_connections else None
    for wire in system.connections:
        _connection(wires, system, wire, old=old)
    for wire in system.clock_connections:
        _wire(wires, wire, wire.output, wire.input)
    add_enumerations(root, quantities)
    add_units(root, quantities)
    _experiment(root, scenario)
    annotations = add(root, SSD, "Annotations")
    annotation = add(annotations, SSC, "Annotation", type="org.macrostep")
    add(annotation, OURS, "Scenario").text = json.dumps(_extras(scenario), default=_plain)
    return root


def _connection(parent: Node, system: System, wire: Connection, *, old: bool) -> None:
    """One connection, or one per element. A conversion is written in full: most tools convert no units themselves."""
    for start, end in ends(system, wire, old=old):
        made = _wire(parent, wire, start, end)
        if not old:
            for side, element in (("start", wire.output_element), ("end", wire.input_element)):
                if element is not None:
                    made.set(f"{side}Indices", element.name.rpartition("[")[2].rstrip("]").replace(",", " "))
        if wire.conversion != IDENTITY or wire.target in system.unconverted:
            made.set("suppressUnitConversion", "true")
            _transformation(made, wire.conversion, system.variable(f"{wire.unit}.{wire.input}", role="inputs").quantity)


def ends(system: System, wire: Connection, *, old: bool) -> list[tuple[str, str]]:
    """The names of what a connection connects, one pair for each element where FMI 2.0 flattens arrays."""
    sources = element_names(system.units[wire.source], wire.output, "outputs", old=old)
    targets = element_names(system.units[wire.unit], wire.input, "inputs", old=old)
    if old and wire.output_element is not None:
        sources = [sources[wire.output_element.at]]
    if old and wire.input_element is not None:
        targets = [targets[wire.input_element.at]]
    return list(zip(sources, targets, strict=True))


def _wire(parent: Node, wire: Connection, start: str, end: str) -> Node:
    attributes = {"startElement": wire.source, "startConnector": start, "endElement": wire.unit, "endConnector": end}
    return add(parent, SSD, "Connection", **attributes)


def _transformation(parent: Node, transformation: Transformation, q: Quantity) -> None:
    if transformation == IDENTITY:
        return
    if isinstance(transformation, Linear):
        values = {"factor": repr(transformation.factor), "offset": repr(transformation.offset)}
        add(parent, SSC, "LinearTransformation", **values)
        return
    table = add(parent, SSC, f"{'Boolean' if q.type is Type.BOOLEAN else 'Integer'}MappingTransformation")
    for entry in transformation.table.items():  # enumerations by their numbers: the two may have different items
        source, target = (literal(v, q) if q.type is Type.BOOLEAN else str(int(v)) for v in entry)
        add(table, SSC, "MapEntry", source=source, target=target)


def element_names(source: UnitSource, name: str, role: str, *, old: bool) -> list[str]:
    """The names of a variable's elements where FMI 2.0 flattens them, as the file spells them; else its own.

    `role` is `inputs`, `outputs`, `parameters` or `initials`.
    """
    variable = {v.name: v for v in getattr(source.interface, role)}[name]
    if not (old and variable.shape):
        return [name]
    return [*source.element_names(variable, role)]


def _experiment(root: Node, scenario: Scenario) -> None:
    """Start and stop time; and the macro step where libcosim looks for it, as SSP has no place of its own."""
    experiment = add(root, SSD, "DefaultExperiment", startTime="0", stopTime=repr(scenario.until))
    algorithm = _osp(experiment, "Algorithm")
    add(algorithm, OSP, "FixedStepAlgorithm", baseStepSize=repr(scenario.h))


def _osp(parent: Node, label: str, **attributes: str) -> Node:
    annotation = add(add(parent, SSD, "Annotations"), SSC, "Annotation", type="com.opensimulationplatform")
    return add(annotation, OSP, label, **attributes)


def _connectors(system: System, name: str, *, old: bool) -> dict[str, list[Variable]]:
    """What a component shows, by kind of connector.

    SSP wants only the connectors that are connected. In SSP 1.0, enumerations that nobody reads are left out: libcosim
    ends its process when it meets one.
    """
    interface = system.units[name].interface
    read = {c.output for c in system.connections if c.source == name}
    outputs = [v for v in interface.outputs if not (old and v.quantity.type is Type.ENUMERATION and v.name not in read)]
    return {"input": list(interface.inputs), "output": outputs, "parameter": list(interface.parameters)}


def _extras(scenario: Scenario) -> dict[str, Any]:
    held = {path: np.asarray(value, dtype=object).tolist() for path, value in scenario.system.held.items()}
    patience = {name: source.describe().isolated for name, source in scenario.system.units.items()}
    return {
        "step": scenario.h,
        "scene": asdict(scenario.scene) if scenario.scene else None,  # type: ignore[call-overload]
        "sockets": {name: socket.name for name, socket in scenario.system.sockets.items()},
        "held": held,
        "algorithm": scenario.algorithm.value,
        "solve_loops": scenario.solve_loops,
        "record": dict(scenario.record),
        "steps": {name: str(ratio) for name, ratio in scenario.system.steps.items()},
        "isolated": {name: seconds for name, seconds in patience.items() if seconds is not None},
        "sources": {path: s for path, s in scenario.sources.items() if path.startswith(("scene.", "experiment."))},
    }


def _plain(value: Any) -> Any:
    """What JSON has no word for: bytes, as hexadecimal digits, and numbers of NumPy."""
    return value.hex() if isinstance(value, bytes) else value.item()


def _component(parent: Node, scenario: Scenario, name: str, *, old: bool) -> list[Quantity]:
    system = scenario.system
    source = system.units[name]
    described = source.describe()
    if described.file is None:
        kind, where = BLOCK_TYPE, BLOCK_SOURCE + described.kind
    elif source.mapping_text() is not None:
        kind, where = MAPPING_TYPE, _mapping_resource(name)
    else:
        kind, where = FMU_TYPE, _resource(system, name, described.file)
    component = add(parent, SSD, "Component", name=name, type=kind, source=where)
    connectors = add(component, SSD, "Connectors")
    shown = _connectors(system, name, old=old)
    for role, variables in shown.items():
        for variable in variables:
            for label in element_names(source, variable.name, f"{role}s", old=old):
                connector = add(connectors, SSD, "Connector", name=label, kind=role)
                _type(connector, SSC, variable.quantity, old=old)
                if not old:
                    _dimensions(connector, variable)
    _clocks(connectors, system, name)
    bindings = add(component, SSD, "ParameterBindings")
    add(bindings, SSD, "ParameterBinding", source=f"resources/{name}.ssv")
    if system.steps.get(name, 1) > 1:
        _osp(component, "StepSizeHint", value=repr(float(system.steps[name] * Fraction(repr(scenario.h)))))
    return [v.quantity for variables in shown.values() for v in variables]


def _clocks(connectors: Node, system: System, name: str) -> None:
    """Connectors of a unit's clocks that are connected."""
    connected = {end for wire in system.clock_connections for end in (wire.origin, wire.target)}
    for clock in system.units[name].interface.clocks:
        if f"{name}.{clock.name}" in connected:
            add(add(connectors, SSD, "Connector", name=clock.name, kind=clock.causality), SSC, "Clock")


def _type(parent: Node, space: str, q: Quantity, *, old: bool) -> Node:
    label = _OLD_NAMES.get(q.type, str(q.type)) if old else str(q.type)
    made = add(parent, space, label)
    if has_unit(q):
        made.set("unit", q.unit)
    if q.type is Type.ENUMERATION and q.enumeration is not None:
        made.set("name", q.enumeration.__name__)
    return made


def _dimensions(parent: Node, variable: Variable) -> None:
    for n in variable.quantity.shape:
        add(parent, SSC, "Dimension", size=str(n))


def _parameter_set(scenario: Scenario, name: str) -> Node:
    """Values of a unit's parameters and other start values, and of its inputs that are held."""
    source, old = scenario.system.units[name], is_old(scenario.system)
    root = etree.Element(qualified(SSV, "ParameterSet"), nsmap={"ssv": SSV, "ssc": SSC})
    root.set("version", "1.0" if old else "2.0")
    root.set("name", scenario.name)
    parameters = add(root, SSV, "Parameters")
    held = scenario.system.held_by(name)
    used: list[Quantity] = []
    for role, values in (("parameters", source.parameters), ("initials", source.parameters), ("inputs", held)):
        for variable in (v for v in getattr(source.interface, role) if v.name in values):
            used.append(variable.quantity)
            given = np.asarray(values[variable.name], dtype=object).ravel()  # objects: bytes keep their zeros
            texts = [literal(x, variable.quantity) for x in given.tolist()]
            labels = element_names(source, variable.name, role, old=old)
            origin = str(scenario.sources.get(f"{name}.{variable.name}", {}).get("source", ""))
            for label, some in zip(labels, [[text] for text in texts] if old else [texts], strict=True):
                parameter = add(parameters, SSV, "Parameter", name=label)
                if origin:
                    parameter.set("description", origin)
                _value(parameter, variable, some, old=old)
    add_units(root, used, space=SSV)
    return root


def _value(parameter: Node, variable: Variable, texts: Sequence[str], *, old: bool) -> None:
    made = _type(parameter, SSV, variable.quantity, old=old)
    if variable.quantity.type.is_number or old:
        made.set("value", " ".join(texts))
    else:
        for text in texts:
            add(made, SSV, "Value", value=text)
    if not old:
        _dimensions(parameter, variable)
