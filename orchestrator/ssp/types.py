"""Types, units, enumerations and transformations, as SSP writes them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Any, Final, TypeAlias

from components.interfaces.conversion import Linear, Lookup
from components.interfaces.quantity import Quantity, Type
from components.interfaces.units_of_measurement import BASE_UNITS, BaseUnit, base_unit
from orchestrator.ssp.archive import Document
from orchestrator.ssp.rules import NS, Node, local

_TYPES: Final = {"Real": Type.FLOAT64, "Integer": Type.INT32} | {str(kind): kind for kind in Type}
TRUTHS: Final = {"true": True, "1": True, "false": False, "0": False}
"""How XML writes truth values"""


@dataclass(frozen=True)
class Definitions:
    """The units and enumerations that one file defines."""

    document: Document
    units: Mapping[str, BaseUnit]
    enumerations: Mapping[str, Mapping[str, int]]

    @staticmethod
    def of(document: Document, root: Node) -> Definitions:
        """Those below the root element of a document."""
        units = {n.get("name", ""): _base_unit(document, n) for n in root.iterfind("*/ssc:Unit", NS)}
        enumerations = {
            n.get("name", ""): {
                item.get("name", ""): int(value)
                for item in n.iterfind("ssc:Item", NS)
                if (value := number(document, item, "value", int)) is not None
            }
            for n in root.iterfind("*/ssc:Enumeration", NS)
        }
        return Definitions(document, units, enumerations)


def number(document: Document, node: Node, name: str, kind: Callable[[str], Any] = float, default: Any = None) -> Any:
    """An attribute as a finite number; the default where it is missing or (the findings say so) is none."""
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
    document.findings.wrong(document.at(node, f"`{name}` of `{local(node)}`"), f"`{text}`", valid)
    return default


def is_true(text: str | None) -> bool:
    """An `xs:boolean`; false where it is missing."""
    return TRUTHS.get((text or "").strip(), False)


def _base_unit(document: Document, node: Node) -> BaseUnit:
    base = node.find("ssc:BaseUnit", NS)
    if base is None:
        return BaseUnit({})
    exponents = {name: number(document, base, name, int, 0) for name in BASE_UNITS if base.get(name)}
    return BaseUnit(
        exponents, number(document, base, "factor", float, 1.0), number(document, base, "offset", float, 0.0)
    )


@dataclass(frozen=True)
class Declared:
    """What a connector, a dictionary entry or a value says of its type; None where it leaves that open."""

    label: str = ""
    """The name of the type's element"""
    unit: str | None = None
    base: BaseUnit | None = None
    items: Mapping[str, int] | None = None
    shape: tuple[int, ...] | None = None
    """Lengths of the array, () for a scalar; None where they depend on something"""

    @property
    def type(self) -> Type | None:
        """The type of signals that this is."""
        return _TYPES.get(self.label)

    @cached_property
    def quantity(self) -> Quantity | None:
        """What is measured, for changes of unit; None where no unit is declared."""
        return None if self.unit is None else Quantity(self.unit, "", base=self.base)

    def fits(self, wanted: Type) -> bool:
        """Whether a variable of the type `wanted` may be declared like this: `Real` and `Integer` mean any width."""
        return (
            self.type in (None, wanted)
            or (self.label == "Real" and wanted.is_float)
            or (self.label == "Integer" and wanted.is_integer)
        )


def declared(definitions: Definitions, node: Node) -> Declared:
    """The type that an element declares among its children."""
    document = definitions.document
    kind = next((child for child in node if local(child) in (*_TYPES, "Clock")), None)
    lengths = [number(document, child, "size", int) for child in node if local(child) == "Dimension"]
    shape = None if None in lengths else tuple(lengths)
    if kind is None:
        return Declared(shape=shape)
    unit, name = kind.get("unit"), kind.get("name")
    base = definitions.units.get(unit) if unit else None
    if unit and base is None and base_unit(unit) is None:
        document.findings.breach(document.at(kind), f"the unit `{unit}`, which the file does not define", "one it does")
    items = definitions.enumerations.get(name) if name else None
    if name and items is None and local(node) != "Parameter":
        found = f"the enumeration `{name}`, which the file does not define"
        document.findings.breach(document.at(kind), found, "one it does")
    return Declared(local(kind), unit, base, items, shape)


@dataclass(frozen=True)
class Names:
    """An EnumerationMappingTransformation: item names by item name."""

    table: Mapping[str, str]


Change: TypeAlias = Linear | Lookup | Names


def change(document: Document, parent: Node) -> Change | None:
    """The transformation that an element carries; None where there is none."""
    node = next((child for child in parent if local(child).endswith("Transformation")), None)
    if node is None:
        return None
    label = local(node)
    if label == "LinearTransformation":
        return Linear(number(document, node, "factor", float, 1.0), number(document, node, "offset", float, 0.0))
    if not label.startswith(("Boolean", "Integer", "Enumeration")):
        document.findings.wrong(document.at(node), f"the transformation `{label}`", "one of SSP 1.0 or 2.0")
        return None
    read = _READERS[label.removesuffix("MappingTransformation")]
    table: dict[Any, Any] = {}
    for entry in node.iterfind("ssc:MapEntry", NS):
        source, target = read(entry.get("source", "")), read(entry.get("target", ""))
        if source is None or target is None:
            told = f"`{entry.get('source')}` to `{entry.get('target')}`"
            document.findings.wrong(document.at(entry, label), told, "values of its type")
        elif source in table:
            document.findings.wrong(
                document.at(entry, label), f"two entries for `{source}`", "one entry for each value"
            )
        else:
            table[source] = target
    return Names(table) if label.startswith("Enumeration") else Lookup(table)


def _whole(text: str) -> int | None:
    try:
        return int(text)
    except ValueError:
        return None


_READERS: Final[Mapping[str, Callable[[str], Any]]] = {
    "Boolean": lambda text: TRUTHS.get(text.strip()),
    "Integer": _whole,
    "Enumeration": str,
}


@dataclass(frozen=True)
class Step:
    """What happens to a value on its way from one connector to the next: a change of unit, then a transformation."""

    where: str
    change: Change | None = None
    as_it_is: bool = False
    """Whether the change of unit is left out (`suppressUnitConversion`)"""
    to: Declared = field(default_factory=Declared)
    """What the end of this step declares"""


def items_of(enumeration: type[IntEnum] | None) -> dict[str, int]:
    """The values of an enumeration's items, by name."""
    return {} if enumeration is None else {item.name: item.value for item in enumeration}
