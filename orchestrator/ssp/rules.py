"""Checking documents against the rules of SSP: the XML schemas for SSP 1.0, a table of elements for SSP 2.0.

No XML schema of SSP 2.0 is at hand, so its element tables stand here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

from components.interfaces.problem import choices
from fmus.toolchain.fmpy_library import ssp_schema
from orchestrator.ssp.vocabulary import (
    SSB,
    SSD,
    SSM,
    SSV,
    STANDARD_NAMESPACES,
    TYPES,
    Attribute,
    SspVersion,
    Tag,
)
from orchestrator.ssp.xml import Node, local_name, qualified

_SCHEMAS: Final = {
    Tag.DESCRIPTION: "SystemStructureDescription.xsd",
    Tag.PARAMETER_SET: "SystemStructureParameterValues.xsd",
    Tag.PARAMETER_MAPPING: "SystemStructureParameterMapping.xsd",
    Tag.SIGNAL_DICTIONARY: "SystemStructureSignalDictionary.xsd",
}
_ROOTS: Final = {
    qualified(space, tag): tag
    for space, tag in (
        (SSD, Tag.DESCRIPTION),
        (SSV, Tag.PARAMETER_SET),
        (SSM, Tag.PARAMETER_MAPPING),
        (SSB, Tag.SIGNAL_DICTIONARY),
    )
}

_TYPE_DECLARATION: Final = (*TYPES, Tag.CLOCK, Tag.DIMENSION)
"""The elements that declare a type and the lengths of an array."""
_ELEMENT: Final = (Tag.CONNECTORS, Tag.ELEMENT_GEOMETRY, Tag.PARAMETER_BINDINGS)
_TRANSFORMATIONS: Final = (
    Tag.LINEAR_TRANSFORMATION,
    Tag.BOOLEAN_MAPPING,
    Tag.INTEGER_MAPPING,
    Tag.ENUMERATION_MAPPING,
)
_COMMON: Final = (Tag.ANNOTATIONS, Tag.META_DATA, Tag.SIGNATURE)
"""What may stand in any element; it is not checked further."""
_CHILDREN: Final[Mapping[str, tuple[str, ...]]] = {
    Tag.DESCRIPTION: (Tag.SYSTEM, Tag.ENUMERATIONS, Tag.UNITS, Tag.DEFAULT_EXPERIMENT),
    Tag.SYSTEM: (
        *_ELEMENT,
        Tag.ELEMENTS,
        Tag.CONNECTIONS,
        Tag.SIGNAL_DICTIONARIES,
        Tag.SYSTEM_GEOMETRY,
        Tag.GRAPHICAL_ELEMENTS,
    ),
    Tag.COMPONENT: _ELEMENT,
    Tag.SIGNAL_DICTIONARY_REFERENCE: _ELEMENT,
    Tag.CONNECTORS: (Tag.CONNECTOR,),
    Tag.CONNECTOR: (*_TYPE_DECLARATION, Tag.CONNECTOR_GEOMETRY),
    Tag.PARAMETER_BINDINGS: (Tag.PARAMETER_BINDING,),
    Tag.PARAMETER_BINDING: (Tag.PARAMETER_VALUES, Tag.PARAMETER_MAPPING),
    Tag.ELEMENTS: (Tag.COMPONENT, Tag.SIGNAL_DICTIONARY_REFERENCE, Tag.SYSTEM),
    Tag.CONNECTIONS: (Tag.CONNECTION,),
    Tag.CONNECTION: (*_TRANSFORMATIONS, Tag.CONNECTION_GEOMETRY),
    Tag.SIGNAL_DICTIONARIES: (Tag.SIGNAL_DICTIONARY,),
    Tag.PARAMETER_SET: (Tag.PARAMETERS, Tag.ENUMERATIONS, Tag.UNITS),
    Tag.PARAMETERS: (Tag.PARAMETER,),
    Tag.PARAMETER: _TYPE_DECLARATION,
    Tag.PARAMETER_MAPPING: (Tag.MAPPING_ENTRY, Tag.PARAMETER_MAPPING),
    Tag.MAPPING_ENTRY: _TRANSFORMATIONS,
    Tag.SIGNAL_DICTIONARY: (Tag.DICTIONARY_ENTRY, Tag.ENUMERATIONS, Tag.UNITS, Tag.SIGNAL_DICTIONARY),
    Tag.DICTIONARY_ENTRY: _TYPE_DECLARATION,
    Tag.ENUMERATIONS: (Tag.ENUMERATION,),
    Tag.ENUMERATION: (Tag.ITEM,),
    Tag.UNITS: (Tag.UNIT,),
    Tag.UNIT: (Tag.BASE_UNIT, Tag.DISPLAY_UNIT),
}
_REQUIRED: Final[Mapping[str, tuple[Attribute, ...]]] = {
    Tag.DESCRIPTION: (Attribute.VERSION, Attribute.NAME),
    Tag.COMPONENT: (Attribute.NAME,),
    Tag.SIGNAL_DICTIONARY_REFERENCE: (Attribute.NAME, Attribute.DICTIONARY),
    Tag.CONNECTOR: (Attribute.NAME, Attribute.KIND),
    Tag.CONNECTION: (Attribute.START_CONNECTOR, Attribute.END_CONNECTOR),
    Tag.PARAMETER_SET: (Attribute.VERSION, Attribute.NAME),
    Tag.PARAMETER: (Attribute.NAME,),
    Tag.MAPPING_ENTRY: (Attribute.SOURCE, Attribute.TARGET),
    Tag.DICTIONARY_ENTRY: (Attribute.NAME,),
    Tag.ENUMERATION: (Attribute.NAME,),
    Tag.ITEM: (Attribute.NAME, Attribute.VALUE),
    Tag.UNIT: (Attribute.NAME,),
    Tag.MAP_ENTRY: (Attribute.SOURCE, Attribute.TARGET),
}


def document_kind(root: Node) -> Tag | None:
    """The kind of a document, which its root element names; None for a document that is not of SSP."""
    return _ROOTS.get(root.tag)


def breaches(root: Node, kind: Tag, version: SspVersion) -> Iterator[tuple[int, str]]:
    """The breaches of the rules of a version in a document, each as its line and what is found there.

    Args:
        root: The root element of the document, or of one that stands inside another.
        kind: The name of that element.
        version: The version that the document claims.
    """
    if version is SspVersion.SSP2:
        yield from _breaches(root)
        return
    # a document inside another one is validated on its own; its lines are those of the other
    validator = ssp_schema(_SCHEMAS[kind])
    if not validator.validate(root):
        for entry in validator.error_log:
            yield entry.line, re.sub(r"\{[^{}]*\}", "", entry.message).rstrip(".")


def _breaches(node: Node) -> Iterator[tuple[int, str]]:
    name = local_name(node)
    for attribute in _REQUIRED.get(name, ()):
        if node.get(attribute) is None:
            yield node.sourceline, f"`{name}` without the attribute `{attribute}`"
    allowed = (*_CHILDREN[name], *_COMMON) if name in _CHILDREN else None
    for child in node:
        label = local_name(child)
        if not label or label in _COMMON:
            continue
        if allowed is not None and (label not in allowed or _namespace(child) not in STANDARD_NAMESPACES):
            yield child.sourceline, f"`{label}` inside `{name}`, which takes {choices(allowed)}"
        else:
            yield from _breaches(child)


def _namespace(node: Node) -> str:
    return str(node.tag)[1:].partition("}")[0]
