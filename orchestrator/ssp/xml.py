"""Reading and writing XML as SSP and FMI have it in common."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, cast

from lxml import etree

from components.interfaces.quantity import TRUTHS, Quantity, Type
from orchestrator.ssp.vocabulary import PREFIXES, SSC, SSD, Attribute, Tag

Node: TypeAlias = Any
"""An element of lxml, whose own type is private."""


def is_true(text: str | None) -> bool:
    """Whether the text of an `xs:boolean` attribute is true; a missing attribute is false."""
    return TRUTHS.get((text or "").strip(), False)


def local_name(node: Node) -> str:
    """The name of an element without its namespace; empty for comments and processing instructions."""
    return str(node.tag).rpartition("}")[2] if isinstance(node.tag, str) else ""


def qualified(space: str, name: str) -> str:
    """A name in a namespace, as lxml writes it."""
    return f"{{{space}}}{name}"


def path_of(space: str, *names: str) -> str:
    """The path that leads down from an element, for the find methods of lxml; all names are in one namespace."""
    return "/".join(qualified(space, name) for name in names)


def new_root(space: str, name: str, *others: str) -> Node:
    """A root element in the namespace `space`, which declares the prefixes of that and of the `others`."""
    return etree.Element(qualified(space, name), nsmap={PREFIXES[s]: s for s in (space, *others)})


def add(
    parent: Node, space: str, name: str, attributes: Mapping[Attribute, str] | Mapping[str, str] | None = None
) -> Node:
    """A new last child of an element, in a namespace."""
    return cast(Any, etree.SubElement)(parent, qualified(space, name), dict(attributes or {}))


def literal(value: Any, q: Quantity) -> str:
    """A scalar value of a quantity as XML writes it."""
    if q.type is Type.BOOLEAN:
        return "true" if value else "false"
    if q.type is Type.BINARY:
        return bytes(value).hex()
    if q.enumeration is not None:
        return q.enumeration.names[int(value)]
    return float_literal(float(value)) if q.type.is_float else str(value)


def float_literal(value: float) -> str:
    """A floating-point number as XML writes it, which spells infinity and NaN in its own way."""
    if math.isnan(value):
        return "NaN"
    return repr(value) if math.isfinite(value) else ("INF" if value > 0 else "-INF")


def has_unit(q: Quantity) -> bool:
    """Whether SSP and FMI can name the unit of measurement: they ask for its definition in base units."""
    return q.type.is_float and bool(q.unit) and q.base_unit is not None


def unit_definitions(quantities: Sequence[Quantity]) -> dict[str, dict[str, str]]:
    """The attributes of `BaseUnit`, in SSP as in FMI, of every unit of measurement in use, by its name."""
    units = {q.unit: q.base_unit for q in quantities if has_unit(q)}
    definitions: dict[str, dict[str, str]] = {}
    for name, base in sorted(units.items(), key=lambda item: item[0]):
        if base is not None:
            attributes = {b: str(n) for b, n in base.exponents.items()}
            attributes |= {str(Attribute.FACTOR): repr(base.factor)} if base.factor != 1 else {}
            attributes |= {str(Attribute.OFFSET): repr(base.offset)} if base.offset else {}
            definitions[name] = attributes
    return definitions


def add_enumerations(root: Node, quantities: Sequence[Quantity]) -> None:
    """Add the definitions of all enumerations in use to a system structure description."""
    enumerations = {q.enumeration.name: q.enumeration for q in quantities if q.enumeration is not None}
    if not enumerations:
        return
    parent = add(root, SSD, Tag.ENUMERATIONS)
    for name, enumeration in sorted(enumerations.items()):
        node = add(parent, SSC, Tag.ENUMERATION, {Attribute.NAME: name})
        for item in enumeration:
            add(node, SSC, Tag.ITEM, {Attribute.NAME: item.name, Attribute.VALUE: str(item.value)})


def add_units(root: Node, quantities: Sequence[Quantity], space: str = SSD) -> None:
    """Add the definitions of all units of measurement in use to a description or a parameter set."""
    if definitions := unit_definitions(quantities):
        parent = add(root, space, Tag.UNITS)
        for name, base in definitions.items():
            add(add(parent, SSC, Tag.UNIT, {Attribute.NAME: name}), SSC, Tag.BASE_UNIT, base)
