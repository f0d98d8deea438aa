"""Small parts of the XML that SSP and FMI have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

from lxml import etree

from components.interfaces.quantity import Quantity, Type
from orchestrator.ssp.rules import SSC, SSD, Node


def literal(value: Any, q: Quantity) -> str:
    """A value as XML writes it."""
    if q.type is Type.BOOLEAN:
        return "true" if value else "false"
    if q.type is Type.BINARY:
        return bytes(value).hex()
    if q.enumeration is not None:
        return q.enumeration(int(value)).name
    return repr(float(value)) if q.type.is_float else str(value)


def has_unit(q: Quantity) -> bool:
    """Whether SSP and FMI can say the unit: they want its definition in base units."""
    return q.type.is_float and bool(q.unit) and q.base_unit is not None


def unit_definitions(quantities: Sequence[Quantity]) -> dict[str, dict[str, str]]:
    """The attributes of `BaseUnit`, in SSP as in FMI, of every unit in use that has a meaning."""
    units = {q.unit: q.base_unit for q in quantities if has_unit(q)}
    found: dict[str, dict[str, str]] = {}
    for name, base in sorted(units.items(), key=lambda item: item[0]):
        if base is not None:
            found[name] = {b: str(n) for b, n in base.exponents.items()}
            found[name] |= {"factor": repr(base.factor)} if base.factor != 1 else {}
            found[name] |= {"offset": repr(base.offset)} if base.offset else {}
    return found


def add(parent: Node, space: str, label: str, /, **attributes: str) -> Node:
    """A new last child of an element, in a namespace."""
    return cast(Any, etree.SubElement)(parent, qualified(space, label), attributes)


def qualified(space: str, name: str) -> str:
    """A name in a namespace, as lxml writes it."""
    return f"{{{space}}}{name}"


def add_enumerations(root: Node, quantities: Sequence[Quantity]) -> None:
    """The definitions of all enumerations in use, for an SSD."""
    kinds = {q.enumeration.__name__: q.enumeration for q in quantities if q.enumeration is not None}
    if not kinds:
        return
    parent = add(root, SSD, "Enumerations")
    for name, kind in sorted(kinds.items()):
        enumeration = add(parent, SSC, "Enumeration", name=name)
        for item in kind:
            add(enumeration, SSC, "Item", name=item.name, value=str(item.value))


def add_units(root: Node, quantities: Sequence[Quantity], space: str = SSD) -> None:
    """The definitions of all units in use, for an SSD or an SSV."""
    if definitions := unit_definitions(quantities):
        parent = add(root, space, "Units")
        for name, base in definitions.items():
            add(add(parent, SSC, "Unit", name=name), SSC, "BaseUnit", **base)
