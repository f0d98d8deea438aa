"""The parts of modelDescription.xml that FMI 2.0 and FMI 3.0 have in common."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType
from typing import Final, TypeAlias

from lxml import etree

from components.interfaces.items import Enumeration
from components.interfaces.quantity import Quantity, Type
from components.interfaces.units_of_measurement import UNITS_OF_MEASUREMENT, base_unit
from fmus.export.fmi_variables import COMMUNICATION_STEP, FmiVariable, FmiVariables

XmlElement: TypeAlias = etree._Element  # noqa: SLF001  # pyright: ignore[reportPrivateUsage] - lxml has no other name
"""An XML element."""

ANNOTATION: Final = "macrostep"
"""The name of vendor annotations of macrostep."""

LOG_CATEGORIES: Final = MappingProxyType(
    {"logStatusError": "why a call returned an error", "logStatusWarning": "outputs that are not finite numbers"}
)


def quantity_of(unit: str) -> str:
    """The quantity of a unit of measurement, which is the name of its type definition too.

    A unit that is not in the table gives the type its own name.
    """
    known = UNITS_OF_MEASUREMENT.get(unit)
    return known.quantity if known else "Quantity_" + unit.replace("/", "_per_").replace(".", "_")


def declared_type(q: Quantity) -> str | None:
    """The name of a variable's type definition; None where it has none."""
    if q.enumeration is not None:
        return q.enumeration.name
    return quantity_of(q.unit) if q.type is Type.FLOAT64 and q.unit else None


def units_of_measurement(variables: FmiVariables) -> list[str]:
    """The units of measurement in use, in order of appearance."""
    floats = (v.variable.quantity for v in variables if v.variable.quantity.type is Type.FLOAT64)
    return list(dict.fromkeys(q.unit for q in floats if q.unit))


def enumerations(variables: FmiVariables) -> list[Enumeration]:
    """The enumerations in use, in order of appearance."""
    declared = (v.variable.quantity.enumeration for v in variables)
    return list(dict.fromkeys(enumeration for enumeration in declared if enumeration is not None))


def root(variables: FmiVariables, fmi_version: str, token_attribute: str, token: str) -> XmlElement:
    """The root element with the attributes that both versions of FMI have.

    Args:
        variables: The variables of the FMU.
        fmi_version: The attribute `fmiVersion`.
        token_attribute: The attribute that holds the token: `guid` or `instantiationToken`.
        token: The token.
    """
    block = variables.block
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


def add_unit_definitions(parent: XmlElement, names: Iterable[str]) -> None:
    """<UnitDefinitions>: each unit of measurement by the exponents of its base units, with its factor and offset."""
    definitions = etree.Element("UnitDefinitions")
    for name in names:
        unit = etree.SubElement(definitions, "Unit", name=name)
        if (meaning := base_unit(name)) is None:
            continue
        attributes = {base: str(exponent) for base, exponent in meaning.exponents.items()}
        attributes |= {} if meaning.factor == 1 else {"factor": number(meaning.factor)}
        attributes |= {} if meaning.offset == 0 else {"offset": number(meaning.offset)}
        etree.SubElement(unit, "BaseUnit", attributes)
    add_if_filled(parent, definitions)


def add_if_filled(parent: XmlElement, definitions: XmlElement) -> None:
    """A list that FMI 2.0 does not allow to be empty."""
    if len(definitions):
        parent.append(definitions)


def add_items(parent: XmlElement, enumeration: Enumeration) -> None:
    """<Item> for each item of an enumeration type."""
    for item in enumeration:
        etree.SubElement(parent, "Item", name=item.name, value=str(item.value))


def add_log_categories(parent: XmlElement) -> None:
    """<LogCategories>: those that the runtime uses."""
    categories = etree.SubElement(parent, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=description)


def add_default_experiment(parent: XmlElement) -> None:
    """<DefaultExperiment>: it starts at 0 and proposes the macro step as step size."""
    etree.SubElement(parent, "DefaultExperiment", startTime="0", stepSize=number(COMMUNICATION_STEP))


def add_output_annotation(parent: XmlElement, variables: FmiVariables) -> None:
    """Our annotation that outputs follow the inputs that were set, without a step; a sampled block's do not."""
    if not variables.sampled:
        etree.SubElement(parent, f"{{urn:{ANNOTATION}}}Outputs", afterSet="true", nsmap={None: f"urn:{ANNOTATION}"})


def value_attributes(v: FmiVariable, start: Iterable[float]) -> dict[str, str]:
    """The attributes of a variable for its type, unit, range and start value, where it has them.

    Args:
        v: The variable.
        start: The start values of the elements that are written; empty for none.
    """
    q = v.variable.quantity
    attributes: dict[str, str] = {}
    if (declared := declared_type(q)) is not None:
        attributes["declaredType"] = declared
    if q.type is Type.FLOAT64 and q.unit:
        attributes["unit"] = q.unit
    for name, limit in (("min", q.min), ("max", q.max)):
        if limit is not None and q.type in (Type.FLOAT64, Type.INT32):
            attributes[name] = text(q.type, limit)
    if values := " ".join(text(q.type, value) for value in start):
        attributes["start"] = values
    return attributes


def text(value_type: Type, value: float) -> str:
    """A value as XML writes it."""
    if value_type is Type.BOOLEAN:
        return "true" if value else "false"
    return number(value) if value_type is Type.FLOAT64 else str(int(value))


def number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    return repr(float(value))


def to_bytes(element: XmlElement) -> bytes:
    """The file whose root is `element`."""
    return etree.tostring(element, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def tool_version() -> str:
    """The version of macrostep."""
    try:
        return version("macrostep")
    except PackageNotFoundError:  # it runs from a checkout without being installed
        return "0.1.0"
