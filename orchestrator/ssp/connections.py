"""The connections that an SSP lists: their direction, and what happens to a value on them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol, TypeAlias

from components.interfaces.problem import choices, did_you_mean
from orchestrator.ssp.archive import Document
from orchestrator.ssp.transformations import ConversionStep, read_transformation
from orchestrator.ssp.types import DeclaredType
from orchestrator.ssp.vocabulary import Attribute, ConnectorKind
from orchestrator.ssp.xml import Node, is_true
from orchestrator.system.named_variables import ElementIndex

ConnectorPath: TypeAlias = tuple[tuple[str, ...], str]
"""A connector in the whole structure: the path of its element, and its name."""

_UNKNOWN: Final = ""
_INDEX: Final = re.compile(r"0*[1-9][0-9]{0,17}")
_ANY: Final = frozenset({ConnectorKind.INOUT, _UNKNOWN})
_PARAMETERS: Final = frozenset({ConnectorKind.PARAMETER, ConnectorKind.STRUCTURAL_PARAMETER})
_IN: Final = frozenset({ConnectorKind.INPUT}) | _PARAMETERS | _ANY
_FIXED: Final = frozenset({ConnectorKind.CALCULATED_PARAMETER, ConnectorKind.CONSTANT})
_OUT: Final = frozenset({ConnectorKind.OUTPUT, ConnectorKind.LOCAL}) | _FIXED | _ANY
_GIVE_PARAMETERS: Final = _PARAMETERS | _FIXED | _ANY


@dataclass(frozen=True)
class Connector:
    """One connector of an element; its kind is empty where the file does not list the connector."""

    name: str
    kind: str
    declared: DeclaredType
    where: str


class ConnectorOwner(Protocol):
    """An element or a system, as its connections need it."""

    @property
    def connectors(self) -> Mapping[str, Connector]:
        """The connectors that the file lists, by name."""
        ...

    @property
    def may_have_others(self) -> bool:
        """Whether the file may leave out connectors that a lenient reader takes to be there."""
        ...

    def connector_path(self, connector: str) -> ConnectorPath:
        """The path of a connector in the whole structure."""
        ...


@dataclass(frozen=True)
class SspConnection:
    """One connection, in the direction of the values, with the connected elements of arrays."""

    source: ConnectorPath
    source_index: ElementIndex
    target: ConnectorPath
    target_index: ElementIndex
    step: ConversionStep


@dataclass(frozen=True)
class _End:
    path: ConnectorPath
    index: ElementIndex
    connector: Connector
    inside: bool
    """Whether the connector belongs to an element in the system, not to the system itself."""

    @property
    def gives(self) -> bool:
        return self.connector.kind in (_OUT if self.inside else _IN)

    @property
    def takes(self) -> bool:
        return self.connector.kind in (_IN if self.inside else _OUT)

    @property
    def described(self) -> str:
        kind = self.connector.kind or "connector"
        article = "an" if kind[0] in "aeiou" else "a"
        return f"{article} {kind}" if self.inside else f"{article} {kind} of the system"


def read_connection(
    document: Document, node: Node, system: ConnectorOwner, elements: Mapping[str, ConnectorOwner]
) -> SspConnection | None:
    """A connection of a system, which leads from output to input whichever of them is its start.

    The attributes `start` and `end` do not give the direction: the kinds of the connectors do, as the text of
    `Connection` in the schema says.

    Args:
        document: The file.
        node: The element `Connection`.
        system: The system that the connection stands in.
        elements: The elements of that system, by name.

    Returns:
        The connection; None where the findings say why it cannot be made.
    """
    where = document.at(node, _described(node))
    ends = _Ends(document, node, where, system, elements)
    start = ends.read(Attribute.START_ELEMENT, Attribute.START_CONNECTOR, Attribute.START_INDICES)
    end = ends.read(Attribute.END_ELEMENT, Attribute.END_CONNECTOR, Attribute.END_INDICES)
    if start is None or end is None:
        return None
    if not (start.gives and end.takes):
        start, end = end, start
    into_parameter = end.connector.kind in _PARAMETERS and end.inside
    if not (start.gives and end.takes) or (into_parameter and start.connector.kind not in _GIVE_PARAMETERS):
        valid = (
            "an output to an input, a parameter to a parameter, and through connectors of the system of the same kind"
        )
        found = f"a connection of {start.described} and {end.described}"
        document.findings.add_problem(where, found, valid)
        return None
    unconverted = is_true(node.get(Attribute.SUPPRESS_UNIT_CONVERSION))
    step = ConversionStep(where, read_transformation(document, node), unconverted, end.connector.declared)
    return SspConnection(start.path, start.index, end.path, end.index, step)


def _described(node: Node) -> str:
    start = (node.get(Attribute.START_ELEMENT), node.get(Attribute.START_CONNECTOR))
    end = (node.get(Attribute.END_ELEMENT), node.get(Attribute.END_CONNECTOR))
    return " -> ".join(".".join(filter(None, names)) for names in (start, end))


@dataclass(frozen=True)
class _Ends:
    """The ends of one connection, which are looked up in its system."""

    document: Document
    node: Node
    where: str
    system: ConnectorOwner
    elements: Mapping[str, ConnectorOwner]

    def read(self, element: Attribute, connector: Attribute, indices: Attribute) -> _End | None:
        """The end that three attributes describe; None where the findings say that there is none."""
        findings, where = self.document.findings, self.where
        owner_name, name = self.node.get(element), self.node.get(connector, "")
        if owner_name and owner_name not in self.elements:
            close = did_you_mean(owner_name, self.elements)
            findings.add_problem(where, f"no element `{owner_name}`", choices(self.elements), close)
            return None
        owner = self.elements[owner_name] if owner_name else self.system
        index = self._index(indices)
        known = owner.connectors
        if name in known:
            return _End(owner.connector_path(name), index, known[name], bool(owner_name))
        found = f"no connector `{name}` of {f'`{owner_name}`' if owner_name else 'the system'}"
        if not (owner_name and owner.may_have_others and findings.lenient):
            findings.add_problem(where, found, choices(known), did_you_mean(name, known))
            return None
        findings.add_breach(where, found, choices(known))
        unlisted = Connector(name, _UNKNOWN, DeclaredType(), where)
        return _End(owner.connector_path(name), index, unlisted, inside=True)

    def _index(self, name: Attribute) -> ElementIndex:
        text = self.node.get(name)
        if text is None:
            return None
        parts = text.split()
        if parts and all(_INDEX.fullmatch(part) for part in parts):
            return tuple(int(part) for part in parts)
        valid = "one whole number for each dimension, counted from 1"
        self.document.findings.add_problem(self.where, f"`{text}` in `{name}`", valid)
        return None
