"""Types, units of measurement and enumerations, as SSP declares them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeAlias

from components.interfaces.items import Enumeration
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.units_of_measurement import BASE_UNITS, BaseUnit, base_unit
from orchestrator.ssp.archive import Document
from orchestrator.ssp.vocabulary import SSC, SSP1_TYPES, TYPES, Attribute, Tag
from orchestrator.ssp.xml import Node, add, has_unit, local_name, qualified

EnumerationItems: TypeAlias = Mapping[str, int]
"""The values of an enumeration's items, by the name of the item."""
_SSP1_NAMES: Final[Mapping[Type, str]] = {kind: tag for tag, kind in SSP1_TYPES.items()}


@dataclass(frozen=True)
class Definitions:
    """The units of measurement and the enumerations that one file defines."""

    document: Document
    units: Mapping[str, BaseUnit]
    enumerations: Mapping[str, EnumerationItems]

    @staticmethod
    def of(document: Document, root: Node) -> Definitions:
        """The definitions below the root element of a document."""
        units = {
            n.get(Attribute.NAME, ""): _base_unit(document, n) for n in root.iterfind(f"*/{qualified(SSC, Tag.UNIT)}")
        }
        enumerations = {
            n.get(Attribute.NAME, ""): _items(document, n)
            for n in root.iterfind(f"*/{qualified(SSC, Tag.ENUMERATION)}")
        }
        return Definitions(document, units, enumerations)


def _items(document: Document, node: Node) -> EnumerationItems:
    return {
        item.get(Attribute.NAME, ""): int(value)
        for item in node.iterfind(qualified(SSC, Tag.ITEM))
        if (value := number(document, item, Attribute.VALUE, int)) is not None
    }


def _base_unit(document: Document, node: Node) -> BaseUnit:
    base = node.find(qualified(SSC, Tag.BASE_UNIT))
    if base is None:
        return BaseUnit({})
    exponents = {name: number(document, base, name, int, 0) for name in BASE_UNITS if base.get(name)}
    factor = number(document, base, Attribute.FACTOR, float, 1.0)
    return BaseUnit(exponents, factor, number(document, base, Attribute.OFFSET, float, 0.0))


def number(document: Document, node: Node, name: str, kind: Callable[[str], Any] = float, default: Any = None) -> Any:
    """An attribute as a finite number.

    Args:
        document: The file of the element.
        node: The element.
        name: The attribute.
        kind: `float`, or `int` for a whole number.
        default: The result where the attribute is missing, or where the findings say that it is not a finite number.
    """
    text = node.get(name)
    if text is None:
        return default
    try:
        value = kind(text.strip())
        if kind is int or math.isfinite(value):
            return value
    except ValueError:
        pass
    valid = "a whole number" if kind is int else "a finite number"
    document.findings.add_problem(document.at(node, f"`{name}` of `{local_name(node)}`"), f"`{text}`", valid)
    return default


@dataclass(frozen=True)
class DeclaredType:
    """The type that a connector, a dictionary entry or a value declares; None stands for what it leaves open.

    Attributes:
        label: The name of the element that gives the type.
        unit: The unit of measurement.
        base: The unit of measurement in base units, as the file defines it.
        items: The items of the enumeration.
        shape: The lengths of the array, () for a scalar; None also where they depend on something.
    """

    label: str = ""
    unit: str | None = None
    base: BaseUnit | None = None
    items: EnumerationItems | None = None
    shape: tuple[int, ...] | None = None

    @property
    def type(self) -> Type | None:
        """The type of signals that the label means."""
        return TYPES.get(self.label)

    @cached_property
    def quantity(self) -> Quantity | None:
        """The quantity that is measured, for unit conversions; None where no unit of measurement is declared."""
        return None if self.unit is None else Quantity(self.unit, "", base=self.base)

    def fits(self, wanted: Type) -> bool:
        """Whether a variable of the type `wanted` may be declared so: `Real` and `Integer` stand for any width."""
        return (
            self.type in (None, wanted)
            or (self.label == Tag.REAL and wanted.is_float)
            or (self.label == Tag.INTEGER and wanted.is_integer)
        )


def read_type(definitions: Definitions, node: Node) -> DeclaredType:
    """The type that an element declares among its children."""
    document = definitions.document
    kind = next((child for child in node if local_name(child) in (*TYPES, Tag.CLOCK)), None)
    lengths = [number(document, child, Attribute.SIZE, int) for child in node if local_name(child) == Tag.DIMENSION]
    shape = None if None in lengths else tuple(lengths)
    if kind is None:
        return DeclaredType(shape=shape)
    unit, name = kind.get(Attribute.UNIT), kind.get(Attribute.NAME)
    base = definitions.units.get(unit) if unit else None
    if unit and base is None and base_unit(unit) is None:
        undefined = f"the unit `{unit}`, which the file does not define"
        document.findings.add_breach(document.at(kind), undefined, "one it does")
    items = definitions.enumerations.get(name) if name else None
    if name and items is None and local_name(node) != Tag.PARAMETER:
        undefined = f"the enumeration `{name}`, which the file does not define"
        document.findings.add_breach(document.at(kind), undefined, "one it does")
    return DeclaredType(local_name(kind), unit, base, items, shape)


def add_type(parent: Node, space: str, q: Quantity, *, ssp1: bool) -> Node:
    """Add the element that declares the type of a quantity, with its unit of measurement or enumeration.

    Args:
        parent: The connector or the parameter.
        space: The namespace of the new element.
        q: The quantity.
        ssp1: Whether the type has its name of SSP 1.0.
    """
    label = _SSP1_NAMES.get(q.type, str(q.type)) if ssp1 else str(q.type)
    node = add(parent, space, label)
    if has_unit(q):
        node.set(Attribute.UNIT, q.unit)
    if q.type is Type.ENUMERATION and q.enumeration is not None:
        node.set(Attribute.NAME, q.enumeration.name)
    return node


def add_dimensions(parent: Node, variable: Variable) -> None:
    """Add the lengths of an array, which SSP 2.0 has, to a connector or a parameter."""
    for n in variable.quantity.shape:
        add(parent, SSC, Tag.DIMENSION, {Attribute.SIZE: str(n)})


def items_of(enumeration: Enumeration | None) -> dict[str, int]:
    """The items of an enumeration of the quantities; empty where there is none."""
    return {} if enumeration is None else enumeration.values
