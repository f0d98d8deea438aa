"""Parameter values of an SSP, from sets (SSV) and mappings (SSM), and the variables and connectors that they reach."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from components.interfaces.problem import choices, did_you_mean
from fmus.reading.unpack import read
from fmus.reading.xml_documents import parse_xml
from orchestrator.ssp.archive import VALID_XML, Document, conforms, read_document, resolve_uri
from orchestrator.ssp.connections import ConnectorPath
from orchestrator.ssp.system_elements import Component, ParameterBindings, SspSystem, SystemElement
from orchestrator.ssp.transformations import ConversionStep, read_transformation
from orchestrator.ssp.types import DeclaredType, Definitions, read_type
from orchestrator.ssp.vocabulary import (
    PARAMETER_MAPPING_TYPE,
    PARAMETER_SET_TYPE,
    SSD,
    SSM,
    SSV,
    Attribute,
    Tag,
)
from orchestrator.ssp.xml import Node, is_true, local_name, path_of, qualified


@dataclass(frozen=True)
class ParameterValue:
    """One value of a parameter set.

    Attributes:
        texts: The value as the file has it, or the values of the elements of an array.
        declared: Its type.
        origin: Where the value comes from, as the file says; else the name of the file.
        step: The conversion by the mapping of the set.
    """

    texts: tuple[str, ...]
    declared: DeclaredType
    origin: str
    step: ConversionStep


@dataclass
class ParameterValues:
    """The values that take effect; each replaced those that came before it.

    Attributes:
        variables: The values of components, by the path of the component and the name of the variable or its element.
        connectors: The values of the connectors of systems.
    """

    variables: dict[tuple[str, ...], dict[str, ParameterValue]] = field(
        default_factory=dict[tuple[str, ...], dict[str, ParameterValue]]
    )
    connectors: dict[ConnectorPath, ParameterValue] = field(default_factory=dict[ConnectorPath, ParameterValue])


HasVariable: TypeAlias = Callable[[Component, str], bool]


def gather_values(root: SspSystem, has_variable: HasVariable) -> ParameterValues:
    """The values of all parameter bindings; outer ones replace inner ones, and later ones earlier ones.

    Values for names that nothing has are passed over, as the standard asks; a remark lists them.

    Args:
        root: The outermost system.
        has_variable: Tells whether a component has a variable of a name.
    """
    values = ParameterValues()
    _gather(root, has_variable, values)
    return values


def _gather(element: SystemElement, has_variable: HasVariable, values: ParameterValues) -> None:
    if isinstance(element, SspSystem):
        for inner in element.elements.values():
            _gather(inner, has_variable, values)
    for bindings in element.bindings:
        document = bindings.definitions.document
        for node in bindings.node.iterfind(qualified(SSD, Tag.PARAMETER_BINDING)):
            given = _values_of_binding(bindings, node)
            unused = [name for name, value in given if not _apply(element, name, value, has_variable, values)]
            if unused:
                names = ", ".join(unused)
                remark = f"{document.at(node)}: no variable has the names of these values: {names}"
                document.findings.remarks.append(remark)


def _apply(
    element: SystemElement, name: str, value: ParameterValue, has_variable: HasVariable, values: ParameterValues
) -> bool:
    """Give a value to all that has this name in an element; false where nothing has."""
    if isinstance(element, Component):
        if not has_variable(element, name):
            return False
        given = values.variables.setdefault(element.path, {})
        given.pop(name, None)  # the order is that in which the values are given
        given[name] = value
        return True
    if not isinstance(element, SspSystem):
        return False
    reached = name in element.connectors
    if reached:
        values.connectors[element.connector_path(name)] = value
    for inner in element.elements.values():
        if name.startswith(f"{inner.name}."):
            reached |= _apply(inner, name[len(inner.name) + 1 :], value, has_variable, values)
    return reached


def _values_of_binding(bindings: ParameterBindings, node: Node) -> Iterator[tuple[str, ParameterValue]]:
    """The values of one binding by name, with its prefix and its mapping applied."""
    document = bindings.definitions.document
    if (kind := node.get(Attribute.TYPE) or PARAMETER_SET_TYPE) != PARAMETER_SET_TYPE:
        where = document.at(node, "parameter binding")
        document.findings.add_problem(where, f"the type `{kind}`", PARAMETER_SET_TYPE)
        return
    inline = node.find(qualified(SSD, Tag.PARAMETER_VALUES))
    parameter_set = _document(bindings, node, Tag.PARAMETER_SET, inline)
    mapping = node.find(qualified(SSD, Tag.PARAMETER_MAPPING))
    if parameter_set is None:
        return
    prefix = node.get(Attribute.PREFIX, "")
    values = {f"{prefix}{name}": value for name, value in _values_of_set(*parameter_set)}
    if mapping is None:
        yield from values.items()
    elif (kind := mapping.get(Attribute.TYPE) or PARAMETER_MAPPING_TYPE) != PARAMETER_MAPPING_TYPE:
        where = document.at(mapping, "parameter mapping")
        document.findings.add_problem(where, f"the type `{kind}`", PARAMETER_MAPPING_TYPE)
    elif (entries := _document(bindings, mapping, Tag.PARAMETER_MAPPING, mapping)) is not None:
        yield from _mapped(*entries, values)


def _document(bindings: ParameterBindings, node: Node, kind: Tag, inline: Node | None) -> tuple[Document, Node] | None:
    """The parameter set or mapping that an element contains or refers to; None where it is unusable."""
    document, source = bindings.definitions.document, node.get(Attribute.SOURCE)
    where = document.at(node, local_name(node))
    if not source:
        content = next((child for child in (() if inline is None else inline) if local_name(child) == kind), None)
        if content is None:
            document.findings.add_problem(where, "neither a source nor a content", f"one of them, a `{kind}`")
            return None
        return (document, content) if conforms(document, content, kind) else None
    if node.get(Attribute.SOURCE_BASE) == "component":
        other = _document_in_component(bindings, source, where, kind)
    else:
        file = resolve_uri(document, source, where)
        other = None if file is None else read_document(document.package, file, kind)
    return None if other is None else (other, other.root)


def _document_in_component(bindings: ParameterBindings, source: str, where: str, kind: Tag) -> Document | None:
    findings, file = bindings.definitions.document.findings, bindings.file
    archive = None
    if file is not None:
        archive = findings.attempt(lambda: read(file, {source}, where, "a component that is a zip archive"))
        if archive is None:
            return None
    content = None if archive is None else archive.files.get(source)
    if file is None or content is None:
        findings.add_problem(where, f"the file `{source}`, which is not in the component", "a file inside it")
        return None
    root = findings.attempt(lambda: parse_xml(content, where, VALID_XML))
    if root is None:
        return None
    document = Document(bindings.definitions.document.package, file / source, root)
    return document if conforms(document, root, kind) else None


def _values_of_set(document: Document, root: Node) -> Iterator[tuple[str, ParameterValue]]:
    definitions = Definitions.of(document, root)
    seen: set[str] = set()
    for node in root.iterfind(path_of(SSV, Tag.PARAMETERS, Tag.PARAMETER)):
        name = node.get(Attribute.NAME, "")
        where = document.at(node, f"parameter `{node.get(Attribute.NAME)}`")
        if name in seen:
            document.findings.add_breach(where, "a second value", "one value for each name")
        seen.add(name)
        typed = next((c for c in node if Attribute.VALUE in c.attrib or local_name(c) != Tag.ANNOTATIONS), None)
        if typed is None:
            document.findings.add_problem(where, "no value", "a type with a value")
            continue
        children = [child for child in typed if local_name(child) == Tag.VALUE]
        texts = tuple(child.get(Attribute.VALUE, child.text or "") for child in children)
        origin = node.get(Attribute.DESCRIPTION) or document.path.name
        declared = read_type(definitions, node)
        yield name, ParameterValue(texts or (typed.get(Attribute.VALUE, ""),), declared, origin, ConversionStep(where))


def _mapped(
    document: Document, root: Node, values: Mapping[str, ParameterValue]
) -> Iterator[tuple[str, ParameterValue]]:
    """The values that the entries of a mapping take from a set, by the names that the entries give them."""
    targets: set[str] = set()
    for node in root.iterfind(qualified(SSM, Tag.MAPPING_ENTRY)):
        source, target = node.get(Attribute.SOURCE, ""), node.get(Attribute.TARGET, "")
        where = document.at(node, f"{source} -> {target}")
        if source not in values:
            close = did_you_mean(source, values)
            document.findings.add_breach(where, f"no value `{source}`", choices(values), close)
            continue
        if target in targets:
            document.findings.add_problem(where, f"a second value for `{target}`", "one entry for each target")
        targets.add(target)
        unconverted = is_true(node.get(Attribute.SUPPRESS_UNIT_CONVERSION))
        step = ConversionStep(where, read_transformation(document, node), unconverted)
        yield target, replace(values[source], step=step)
