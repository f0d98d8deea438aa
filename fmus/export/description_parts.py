"""What the modelDescription.xml of FMI 2.0 and that of FMI 3.0 say alike."""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType
from typing import Final, TypeAlias

from lxml import etree

from components.interfaces.quantity import Quantity, Type
from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT, base_unit
from fmus.export.fmi_variables import COMMUNICATION_STEP, FmiVariable, Interface

Element: TypeAlias = etree._Element  # noqa: SLF001  # pyright: ignore[reportPrivateUsage] - lxml has no other name
"""An XML element."""

ANNOTATION: Final = "macrostep"
"""Our name in vendor annotations."""

LOG_CATEGORIES: Final = MappingProxyType(
    {"logStatusError": "why a call returned an error", "logStatusWarning": "outputs that are not finite numbers"}
)


def quantity_of(unit: str) -> str:
    """What a unit of measurement measures, as the name of a type; one that is not in our table names its own type."""
    known = UNITS_OF_MEASUREMENT.get(unit)
    return known.quantity if known else "Quantity_" + unit.replace("/", "_per_").replace(".", "_")


def declared_type(q: Quantity) -> str | None:
    """The name of a variable's type definition; None for types without one."""
    if q.enumeration is not None:
        return q.enumeration.__name__
    return quantity_of(q.unit) if q.type is Type.FLOAT64 else None


def units(interface: Interface) -> list[str]:
    """The units in use, in order of appearance."""
    return list(dict.fromkeys(v.variable.quantity.unit for v in interface if v.variable.quantity.type is Type.FLOAT64))


def enumerations(interface: Interface) -> list[type[IntEnum]]:
    """The enumerations in use, in order of appearance."""
    found = (v.variable.quantity.enumeration for v in interface)
    return list(dict.fromkeys(kind for kind in found if kind is not None))


def root(interface: Interface, fmi_version: str, token_attribute: str, token: str) -> Element:
    """The root element with the attributes that both versions have."""
    block = interface.block
    return etree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": fmi_version,
            "modelName": block.name,
            token_attribute: token,
            "description": block.summary,
            "version": tool_version(),
            "generationTool": f"macrostep {tool_version()}",
            "variableNamingConvention": "structured",
        },
    )


def add_units(parent: Element, names: Iterable[str]) -> None:
    """<UnitDefinitions>: each unit by the exponents of its base units, and its factor and offset where it has any."""
    definitions = etree.SubElement(parent, "UnitDefinitions")
    for name in names:
        unit = etree.SubElement(definitions, "Unit", name=name)
        if (meaning := base_unit(name)) is None:
            continue
        attributes = {base: str(exponent) for base, exponent in meaning.exponents.items()}
        attributes |= {} if meaning.factor == 1 else {"factor": number(meaning.factor)}
        attributes |= {} if meaning.offset == 0 else {"offset": number(meaning.offset)}
        etree.SubElement(unit, "BaseUnit", attributes)


def add_items(parent: Element, kind: type[IntEnum]) -> None:
    """The items of an enumeration type."""
    for item in kind:
        etree.SubElement(parent, "Item", name=item.name, value=str(item.value))


def add_log_categories(parent: Element) -> None:
    """<LogCategories>: what the runtime logs."""
    categories = etree.SubElement(parent, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=description)


def add_default_experiment(parent: Element) -> None:
    """<DefaultExperiment>: from 0, with the macro step."""
    etree.SubElement(parent, "DefaultExperiment", startTime="0", stepSize=number(COMMUNICATION_STEP))


def add_promise(parent: Element, interface: Interface) -> None:
    """Our annotation, where it holds: outputs read after inputs were set show these inputs, without a step."""
    if not interface.sampled:
        etree.SubElement(parent, f"{{urn:{ANNOTATION}}}Outputs", afterSet="true", nsmap={None: f"urn:{ANNOTATION}"})


def value_attributes(v: FmiVariable, start: Iterable[float]) -> dict[str, str]:
    """Type, unit, range and start value; those that apply."""
    q = v.variable.quantity
    found: dict[str, str] = {}
    if (declared := declared_type(q)) is not None:
        found["declaredType"] = declared
    if q.type is Type.FLOAT64:
        found["unit"] = q.unit
    for name, limit in (("min", q.min), ("max", q.max)):
        if limit is not None and q.type in (Type.FLOAT64, Type.INT32):
            found[name] = text(q.type, limit)
    if values := " ".join(text(q.type, value) for value in start):
        found["start"] = values
    return found


def text(kind: Type, value: float) -> str:
    """A value as XML writes it."""
    if kind is Type.BOOLEAN:
        return "true" if value else "false"
    return number(value) if kind is Type.FLOAT64 else str(int(value))


def number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    return repr(float(value))


def to_bytes(element: Element) -> bytes:
    """The XML file."""
    return etree.tostring(element, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def tool_version() -> str:
    """The version of macrostep."""
    try:
        return version("macrostep")
    except PackageNotFoundError:  # run from a checkout
        return "0.1.0"
