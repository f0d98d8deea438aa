"""Connections of an SSP: which way they lead, and what happens to a value on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol, TypeAlias

from components.interfaces.problem import choices, did_you_mean
from orchestrator.ssp.archive import Document
from orchestrator.ssp.rules import Node
from orchestrator.ssp.types import Declared, Step, change, is_true

Port: TypeAlias = tuple[tuple[str, ...], str]
"""A connector in the whole: the path of its element, and its name"""
Index: TypeAlias = tuple[int, ...] | None
"""One element of an array, counted from 1; None for all of it"""

_IN: Final = frozenset({"input", "parameter", "structuralParameter"})
_OUT: Final = frozenset({"output", "calculatedParameter", "constant", "local"})
_ANY: Final = frozenset({"inout", ""})
_PARAMETERS: Final = frozenset({"parameter", "structuralParameter"})
_GIVE_PARAMETERS: Final = _PARAMETERS | {"calculatedParameter", "constant"} | _ANY


@dataclass(frozen=True)
class Connector:
    """One connector of an element; its kind is empty where the file does not list it."""

    name: str
    kind: str
    declared: Declared
    where: str


class HasConnectors(Protocol):
    """An element, as connections see it."""

    @property
    def connectors(self) -> Mapping[str, Connector]:
        """By name."""
        ...

    def port(self, connector: str) -> Port:
        """Where a connector stands in the whole."""
        ...


@dataclass(frozen=True)
class Wire:
    """One connection, in the direction of the values."""

    source: Port
    source_at: Index
    target: Port
    target_at: Index
    step: Step


@dataclass(frozen=True)
class _End:
    port: Port
    at: Index
    connector: Connector
    inside: bool
    """Whether it is a connector of an element in the system, not of the system itself"""

    @property
    def gives(self) -> bool:
        return self.connector.kind in (_OUT if self.inside else _IN) | _ANY

    @property
    def takes(self) -> bool:
        return self.connector.kind in (_IN if self.inside else _OUT) | _ANY


def wire(document: Document, node: Node, system: HasConnectors, elements: Mapping[str, HasConnectors]) -> Wire | None:
    """A connection of a system; None where it cannot be made: the findings say why.

    `start` and `end` do not say which way the values go: the kinds of the connectors do, as the standard has it (the
    text of `Connection` in its schema).
    """
    where = document.at(node, _told(node))
    read = _Ends(document, node, where, system, elements)
    start, end = read.end("start"), read.end("end")
    if start is None or end is None:
        return None
    if not (start.gives and end.takes):
        start, end = end, start
    kinds = start.connector.kind, end.connector.kind
    into_parameter = end.connector.kind in _PARAMETERS and end.inside
    if not (start.gives and end.takes) or (into_parameter and kinds[0] not in _GIVE_PARAMETERS):
        valid = (
            "an output to an input, a parameter to a parameter, and through connectors of the system of the same kind"
        )
        document.findings.wrong(where, f"a connection of {_kind(start)} and {_kind(end)}", valid)
        return None
    as_it_is = is_true(node.get("suppressUnitConversion"))
    step = Step(where, change(document, node), as_it_is, end.connector.declared)
    return Wire(start.port, start.at, end.port, end.at, step)


def _kind(end: _End) -> str:
    kind = end.connector.kind or "connector"
    article = "an" if kind[0] in "aeiou" else "a"
    return f"{article} {kind}" if end.inside else f"{article} {kind} of the system"


def _told(node: Node) -> str:
    sides = [".".join(filter(None, (node.get(f"{s}Element"), node.get(f"{s}Connector")))) for s in ("start", "end")]
    return " -> ".join(sides)


@dataclass(frozen=True)
class _Ends:
    """One connection whose ends are looked up."""

    document: Document
    node: Node
    where: str
    system: HasConnectors
    elements: Mapping[str, HasConnectors]

    def end(self, side: str) -> _End | None:
        """The `start` or the `end`; None where there is none: the findings say why."""
        findings, where = self.document.findings, self.where
        name, connector = self.node.get(f"{side}Element"), self.node.get(f"{side}Connector", "")
        if name and name not in self.elements:
            findings.wrong(where, f"no element `{name}`", choices(self.elements), did_you_mean(name, self.elements))
            return None
        element = self.elements[name] if name else self.system
        at = _index(self.document, self.node, f"{side}Indices", where)
        known = element.connectors
        if connector in known:
            return _End(element.port(connector), at, known[connector], bool(name))
        told = f"no connector `{connector}` of {f'`{name}`' if name else 'the system'}"
        if not (name and hasattr(element, "file") and findings.lenient):
            findings.wrong(where, told, choices(known), did_you_mean(connector, known))
            return None
        findings.breach(where, told, choices(known))
        return _End(element.port(connector), at, Connector(connector, "", Declared(), where), inside=True)


def _index(document: Document, node: Node, name: str, where: str) -> Index:
    text = node.get(name)
    if text is None:
        return None
    parts = text.split()
    if parts and all(part.isdigit() and int(part) > 0 for part in parts):
        return tuple(int(part) for part in parts)
    document.findings.wrong(where, f"`{text}` in `{name}`", "one whole number for each dimension, counted from 1")
    return None
