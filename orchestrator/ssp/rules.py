"""The rules that documents of SSP are measured by: the schema for SSP 1.0; its element tables, as text, for SSP 2.0."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final, TypeAlias

from components.interfaces.problem import choices
from fmus.toolchain.fmpy_library import ssp_schema

Node: TypeAlias = Any
"""An element of lxml, whose own type is private"""

SSD: Final = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC: Final = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV: Final = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM: Final = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SSB: Final = "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
NS: Final = {"ssd": SSD, "ssc": SSC, "ssv": SSV, "ssm": SSM, "ssb": SSB}

FMU_TYPE: Final = "application/x-fmu-sharedlibrary"
DEFINITION_TYPE: Final = "application/x-ssp-definition"
PACKAGE_TYPE: Final = "application/x-ssp-package"
BLOCK_TYPE: Final = "application/x-macrostep-block"
MAPPING_TYPE: Final = "application/x-macrostep-mapping"
"""A mapping file, which names its FMU; the component's connectors are those of a socket"""

DESCRIPTION: Final = "SystemStructureDescription"
VALUES: Final = "ParameterSet"
MAPPING: Final = "ParameterMapping"
DICTIONARY: Final = "SignalDictionary"
_ROOTS: Final = {
    f"{{{SSD}}}{DESCRIPTION}": (DESCRIPTION, "SystemStructureDescription.xsd"),
    f"{{{SSV}}}{VALUES}": (VALUES, "SystemStructureParameterValues.xsd"),
    f"{{{SSM}}}{MAPPING}": (MAPPING, "SystemStructureParameterMapping.xsd"),
    f"{{{SSB}}}{DICTIONARY}": (DICTIONARY, "SystemStructureSignalDictionary.xsd"),
}

_TYPES: Final = (
    "Real Integer Float64 Float32 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Enumeration Binary "
    "Clock"
)
_ELEMENT: Final = "Connectors ElementGeometry ParameterBindings"
_CHANGE: Final = (
    "LinearTransformation BooleanMappingTransformation IntegerMappingTransformation EnumerationMappingTransformation"
)
_COMMON: Final = "Annotations MetaData Signature"
_CHILDREN: Final = {
    "SystemStructureDescription": "System Enumerations Units DefaultExperiment",
    "System": f"{_ELEMENT} Elements Connections SignalDictionaries SystemGeometry GraphicalElements",
    "Component": _ELEMENT,
    "SignalDictionaryReference": _ELEMENT,
    "Connectors": "Connector",
    "Connector": f"{_TYPES} Dimension ConnectorGeometry",
    "ParameterBindings": "ParameterBinding",
    "ParameterBinding": "ParameterValues ParameterMapping",
    "Elements": "Component SignalDictionaryReference System",
    "Connections": "Connection",
    "Connection": f"{_CHANGE} ConnectionGeometry",
    "SignalDictionaries": "SignalDictionary",
    "ParameterSet": "Parameters Enumerations Units",
    "Parameters": "Parameter",
    "Parameter": f"{_TYPES} Dimension",
    "ParameterMapping": "MappingEntry ParameterMapping",
    "MappingEntry": _CHANGE,
    "SignalDictionary": "DictionaryEntry Enumerations Units SignalDictionary",
    "DictionaryEntry": f"{_TYPES} Dimension",
    "Enumerations": "Enumeration",
    "Enumeration": "Item",
    "Units": "Unit",
    "Unit": "BaseUnit DisplayUnit",
}
_REQUIRED: Final = {
    "SystemStructureDescription": "version name",
    "Component": "name",
    "SignalDictionaryReference": "name dictionary",
    "Connector": "name kind",
    "Connection": "startConnector endConnector",
    "ParameterSet": "version name",
    "Parameter": "name",
    "MappingEntry": "source target",
    "DictionaryEntry": "name",
    "Enumeration": "name",
    "Item": "name value",
    "Unit": "name",
    "MapEntry": "source target",
}


def kind_of(root: Node) -> str | None:
    """What a document is, by its root element; None for one that is not of SSP."""
    return _ROOTS.get(root.tag, (None,))[0]


def local(node: Node) -> str:
    """The name of an element without its namespace; empty for comments and processing instructions."""
    return str(node.tag).rpartition("}")[2] if isinstance(node.tag, str) else ""


def breaches(root: Node, kind: str, version: str) -> Iterator[tuple[int, str]]:
    """Lines of a document that break the rules of its version, and how."""
    if version.startswith("2"):
        yield from _breaches(root)
        return
    # a document inside another is measured as one of its own, with its lines in the other
    judge = ssp_schema(next(name for known, name in _ROOTS.values() if known == kind))
    if not judge.validate(root):
        for entry in judge.error_log:
            yield entry.line, re.sub(r"\{[^}]*\}", "", entry.message).rstrip(".")


def _breaches(node: Node) -> Iterator[tuple[int, str]]:
    name = local(node)
    for attribute in _REQUIRED.get(name, "").split():
        if node.get(attribute) is None:
            yield node.sourceline, f"`{name}` without the attribute `{attribute}`"
    known = f"{_CHILDREN[name]} {_COMMON}".split() if name in _CHILDREN else None
    for child in node:
        label = local(child)
        if not label or label in _COMMON.split():
            continue
        if known is not None and (label not in known or str(child.tag)[1:].partition("}")[0] not in NS.values()):
            yield child.sourceline, f"`{label}` inside `{name}`, which takes {choices(known)}"
        else:
            yield from _breaches(child)
