"""The transformations that connections and entries of parameter mappings carry, read and written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from components.interfaces.conversion import IDENTITY, Linear, Lookup, Transformation
from components.interfaces.quantity import TRUTHS, Quantity, Type
from orchestrator.ssp.archive import VALID_VERSIONS, Document
from orchestrator.ssp.types import DeclaredType, number
from orchestrator.ssp.vocabulary import SSC, Attribute, Tag
from orchestrator.ssp.xml import Node, add, literal, local_name, qualified


@dataclass(frozen=True)
class EnumerationMapping:
    """An EnumerationMappingTransformation: the names of items by the names of items."""

    table: Mapping[str, str]


DeclaredTransformation: TypeAlias = Linear | Lookup | EnumerationMapping


@dataclass(frozen=True)
class ConversionStep:
    """What happens to a value between one connector and the next: a unit conversion, then a transformation.

    Attributes:
        where: The connection or the entry of a mapping, for messages.
        transformation: The transformation that it carries.
        unconverted: Whether the unit conversion is left out (`suppressUnitConversion`).
        to: The type that the end of this step declares.
    """

    where: str
    transformation: DeclaredTransformation | None = None
    unconverted: bool = False
    to: DeclaredType = field(default_factory=DeclaredType)


def read_transformation(document: Document, parent: Node) -> DeclaredTransformation | None:
    """The transformation that an element carries; None where there is none, or where the findings refuse it."""
    node = next((child for child in parent if local_name(child).endswith("Transformation")), None)
    if node is None:
        return None
    label = local_name(node)
    if label == Tag.LINEAR_TRANSFORMATION:
        factor = number(document, node, Attribute.FACTOR, float, 1.0)
        return Linear(factor, number(document, node, Attribute.OFFSET, float, 0.0))
    if label not in _ENTRY_READERS:
        found, valid = f"the transformation `{label}`", f"one of SSP {VALID_VERSIONS}"
        document.findings.add_problem(document.at(node), found, valid)
        return None
    table = _read_table(document, node, _ENTRY_READERS[label])
    return EnumerationMapping(table) if label == Tag.ENUMERATION_MAPPING else Lookup(table)


def _read_table(document: Document, node: Node, read: Callable[[str], Any]) -> dict[Any, Any]:
    table: dict[Any, Any] = {}
    for entry in node.iterfind(qualified(SSC, Tag.MAP_ENTRY)):
        texts = [entry.get(name) for name in (Attribute.SOURCE, Attribute.TARGET)]
        source, target = (read(text or "") for text in texts)
        where = document.at(entry, local_name(node))
        if source is None or target is None:
            document.findings.add_problem(where, f"`{texts[0]}` to `{texts[1]}`", "values of its type")
        elif source in table:
            document.findings.add_problem(where, f"two entries for `{source}`", "one entry for each value")
        else:
            table[source] = target
    return table


def _whole_number(text: str) -> int | None:
    try:
        return int(text)
    except ValueError:
        return None


_ENTRY_READERS: Final[Mapping[str, Callable[[str], Any]]] = {
    Tag.BOOLEAN_MAPPING: lambda text: TRUTHS.get(text.strip()),
    Tag.INTEGER_MAPPING: _whole_number,
    Tag.ENUMERATION_MAPPING: str,
}


def add_transformation(parent: Node, transformation: Transformation, q: Quantity) -> None:
    """Add a transformation into the quantity `q` to a connection; the identity needs no element."""
    if transformation == IDENTITY:
        return
    if isinstance(transformation, Linear):
        values = {Attribute.FACTOR: repr(transformation.factor), Attribute.OFFSET: repr(transformation.offset)}
        add(parent, SSC, Tag.LINEAR_TRANSFORMATION, values)
        return
    table = add(parent, SSC, Tag.BOOLEAN_MAPPING if q.type is Type.BOOLEAN else Tag.INTEGER_MAPPING)
    for entry in transformation.table.items():  # enumerations by their numbers: the two may have different items
        source, target = (literal(v, q) if q.type is Type.BOOLEAN else str(int(v)) for v in entry)
        add(table, SSC, Tag.MAP_ENTRY, {Attribute.SOURCE: source, Attribute.TARGET: target})
