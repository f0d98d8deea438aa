"""Writing a system as one SSP file (System Structure and Parameterization), which `reader` reads back.

A system of FMI 2.0 FMUs is written as SSP 1.0, element by element, for other tools; with FMI 3.0 FMUs or blocks of this
process it is SSP 2.0, whose connectors have dimensions. What SSP has no element for (scene, sockets, held inputs)
stands in annotations of type `org.macrostep`, which other tools pass over. All parameter sets carry the scenario's
name: Ecos applies one set by its name to the whole system.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Final

import numpy as np
from lxml import etree

from components.interfaces.conversion import IDENTITY
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from fmus.toolchain.archives import write_archive
from orchestrator.ssp.annotation import annotation_of, table_path
from orchestrator.ssp.default_experiment import add_experiment, add_step_hint, new_annotation
from orchestrator.ssp.element_names import connected_names, element_names, ssp_version
from orchestrator.ssp.parameter_set_writer import parameter_set
from orchestrator.ssp.transformations import add_transformation
from orchestrator.ssp.types import add_dimensions, add_type
from orchestrator.ssp.vocabulary import (
    ANNOTATION_TYPE,
    BLOCK_SOURCE,
    BLOCK_TYPE,
    DESCRIPTION_FILE,
    FMU_TYPE,
    MAPPING_SUFFIX,
    MAPPING_TYPE,
    OSP,
    OURS,
    PARAMETER_SET_SUFFIX,
    SSC,
    SSD,
    SSV,
    Attribute,
    ConnectorKind,
    SspVersion,
    Tag,
    resource,
)
from orchestrator.ssp.xml import Node, add, add_enumerations, add_units, new_root
from orchestrator.system.connection import ArrayElement, Connection
from orchestrator.system.experiment import Scenario
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System

_ROLES: Final[Mapping[ConnectorKind, str]] = {
    ConnectorKind.INPUT: "inputs",
    ConnectorKind.OUTPUT: "outputs",
    ConnectorKind.PARAMETER: "parameters",
}
"""The list of the interface that the variables behind connectors stand in."""


def write(scenario: Scenario, path: Path) -> None:
    """Write a scenario's system with its FMUs and parameter values as one `.ssp` file; equal systems, equal bytes.

    Args:
        scenario: The system and its experiment.
        path: The file, which is replaced if it exists.

    Raises:
        RequestError: The folder cannot be written to.
    """
    files: dict[str, bytes] = {DESCRIPTION_FILE: _as_text(_description(scenario))}
    for name, source in scenario.system.units.items():
        files[_parameter_set_path(name)] = _as_text(parameter_set(scenario, name))
        if (file := source.describe().file) is not None:
            fmu = _fmu_path(scenario.system, name, file)
            files[fmu] = file.read_bytes()
            if (mapping := source.mapping_text(Path(fmu).name)) is not None:
                files[_mapping_path(name)] = mapping.encode()
    if scenario.system.table is not None:
        files[table_path(scenario.system.table)] = scenario.system.table.content
    write_archive(path, files)


def _parameter_set_path(unit: str) -> str:
    return resource(f"{unit}{PARAMETER_SET_SUFFIX}")


def _mapping_path(unit: str) -> str:
    return resource(f"{unit}{MAPPING_SUFFIX}")


def _fmu_path(system: System, unit: str, path: Path) -> str:
    """The path of a unit's FMU in the archive; the unit's name comes first where another file has the same name."""
    files = {file for source in system.units.values() if (file := source.describe().file) is not None}
    shared = any(file.name == path.name for file in files - {path})
    return resource(f"{unit}.{path.name}" if shared else path.name)


def _as_text(root: Node) -> bytes:
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _description(scenario: Scenario) -> Node:
    system, version = scenario.system, ssp_version(scenario.system)
    ssp1 = version is SspVersion.SSP1
    root = new_root(SSD, Tag.DESCRIPTION, SSC, SSV, OSP)
    root.set(Attribute.VERSION, version)
    root.set(Attribute.NAME, scenario.name)
    top = add(root, SSD, Tag.SYSTEM, {Attribute.NAME: scenario.name, Attribute.DESCRIPTION: scenario.title})
    elements = add(top, SSD, Tag.ELEMENTS)
    quantities: list[Quantity] = []
    for name in system.units:
        quantities += _add_component(elements, scenario, name, ssp1=ssp1)
    if system.connections or system.clock_connections:
        connections = add(top, SSD, Tag.CONNECTIONS)
        for connection in system.connections:
            _add_connections(connections, system, connection, ssp1=ssp1)
        for connection in system.clock_connections:
            _add_connection(connections, connection, connection.output, connection.input)
    add_enumerations(root, quantities)
    add_units(root, quantities)
    add_experiment(root, scenario.h, scenario.start, scenario.until)
    add(new_annotation(root, ANNOTATION_TYPE), OURS, Tag.SCENARIO).text = annotation_of(scenario)
    return root


def _add_connections(parent: Node, system: System, connection: Connection, *, ssp1: bool) -> None:
    """Add one connection, or one for each element of an array.

    A unit conversion is written as a transformation: most tools convert no units of measurement themselves.
    """
    output = system.variable(f"{connection.source}.{connection.output}")
    target = system.variable(f"{connection.unit}.{connection.input}", role="inputs")
    for start, end in connected_names(system, connection, flat=ssp1):
        node = _add_connection(parent, connection, start, end)
        if not ssp1 and connection.output_element is not None:
            node.set(Attribute.START_INDICES, _indices(output, connection.output_element))
        if not ssp1 and connection.input_element is not None:
            node.set(Attribute.END_INDICES, _indices(target, connection.input_element))
        if connection.conversion != IDENTITY or connection.target in system.unconverted:
            node.set(Attribute.SUPPRESS_UNIT_CONVERSION, "true")
            add_transformation(node, connection.conversion, target.quantity)


def _indices(variable: Variable, element: ArrayElement) -> str:
    """The index of an element in each dimension, counted from 1."""
    return " ".join(str(i + 1) for i in np.unravel_index(element.at, variable.shape))


def _add_connection(parent: Node, connection: Connection, start: str, end: str) -> Node:
    attributes = {
        Attribute.START_ELEMENT: connection.source,
        Attribute.START_CONNECTOR: start,
        Attribute.END_ELEMENT: connection.unit,
        Attribute.END_CONNECTOR: end,
    }
    return add(parent, SSD, Tag.CONNECTION, attributes)


def _add_component(parent: Node, scenario: Scenario, name: str, *, ssp1: bool) -> list[Quantity]:
    """Add a unit as a component; the result is what its connectors measure."""
    system = scenario.system
    source = system.units[name]
    kind, path = _type_and_source(system, name)
    component = add(parent, SSD, Tag.COMPONENT, {Attribute.NAME: name, Attribute.TYPE: kind, Attribute.SOURCE: path})
    if (interface_type := source.describe().interface_type) is not None:
        component.set(Attribute.IMPLEMENTATION, interface_type)
    connectors = add(component, SSD, Tag.CONNECTORS)
    variables = _connected_variables(system, name, ssp1=ssp1)
    for connector_kind, of_kind in variables.items():
        for variable in of_kind:
            _add_connectors(connectors, source, variable, connector_kind, ssp1=ssp1)
    _add_clocks(connectors, system, name)
    bindings = add(component, SSD, Tag.PARAMETER_BINDINGS)
    add(bindings, SSD, Tag.PARAMETER_BINDING, {Attribute.SOURCE: _parameter_set_path(name)})
    if system.steps.get(name, 1) > 1:
        add_step_hint(component, float(system.steps[name] * Fraction(repr(scenario.h))))
    return [v.quantity for of_kind in variables.values() for v in of_kind]


def _type_and_source(system: System, name: str) -> tuple[str, str]:
    """The media type of a unit and where it is found."""
    source = system.units[name]
    described = source.describe()
    if described.file is None:
        return BLOCK_TYPE, BLOCK_SOURCE + described.kind
    if source.mapping_text() is not None:
        return MAPPING_TYPE, _mapping_path(name)
    return FMU_TYPE, _fmu_path(system, name, described.file)


def _connected_variables(system: System, name: str, *, ssp1: bool) -> dict[ConnectorKind, Sequence[Variable]]:
    """The variables of a unit that have connectors, by the kind of these.

    SSP needs connectors only where something is connected. In SSP 1.0, enumerations that nothing reads are left out:
    libcosim ends its process when it meets one.
    """
    interface = system.units[name].interface
    read = {c.output for c in system.connections_from(name)}
    outputs = [
        v for v in interface.outputs if not (ssp1 and v.quantity.type is Type.ENUMERATION and v.name not in read)
    ]
    return {
        ConnectorKind.INPUT: interface.inputs,
        ConnectorKind.OUTPUT: outputs,
        ConnectorKind.PARAMETER: interface.parameters,
    }


def _add_connectors(parent: Node, source: UnitSource, variable: Variable, kind: ConnectorKind, *, ssp1: bool) -> None:
    """Add the connector of a variable, or in SSP 1.0 those of its elements."""
    for name in element_names(source, variable.name, _ROLES[kind], flat=ssp1):
        connector = add(parent, SSD, Tag.CONNECTOR, {Attribute.NAME: name, Attribute.KIND: kind})
        add_type(connector, SSC, variable.quantity, ssp1=ssp1)
        if not ssp1:
            add_dimensions(connector, variable)


def _add_clocks(connectors: Node, system: System, name: str) -> None:
    """Add connectors for the clocks of a unit that are connected."""
    connected = {end for connection in system.clock_connections for end in (connection.origin, connection.target)}
    for clock in system.units[name].interface.clocks:
        if f"{name}.{clock.name}" in connected:
            attributes = {Attribute.NAME: clock.name, Attribute.KIND: clock.causality}
            add(add(connectors, SSD, Tag.CONNECTOR, attributes), SSC, Tag.CLOCK)
