"""Parameter values of an SSP: sets (SSV) and mappings (SSM), inside a description or beside it, and what they reach."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from components.interfaces.problem import choices, did_you_mean
from fmus.reading.unpack import parse_xml, read
from orchestrator.ssp.archive import Document, is_valid, read_document, resolve
from orchestrator.ssp.connections import Port
from orchestrator.ssp.rules import MAPPING, NS, VALUES, Node, local
from orchestrator.ssp.structure import Bindings, Component, Element, Group
from orchestrator.ssp.types import Declared, Definitions, Step, change, declared, is_true

_SET_TYPE: Final = "application/x-ssp-parameter-set"
_MAPPING_TYPE: Final = "application/x-ssp-parameter-mapping"


@dataclass(frozen=True)
class Value:
    """One value of a parameter set, and what its mapping does to it."""

    texts: tuple[str, ...]
    declared: Declared
    origin: str
    """Where it comes from, as the file says, else the file"""
    step: Step


@dataclass
class Values:
    """What values reach, those that count last: they replace the ones before."""

    variables: dict[tuple[str, ...], dict[str, Value]] = field(default_factory=dict[tuple[str, ...], dict[str, Value]])
    """By path of the component and name of the variable, or of an element of it"""
    connectors: dict[Port, Value] = field(default_factory=dict[Port, Value])
    """Of systems"""


def gather(root: Group, knows: Callable[[Component, str], bool]) -> Values:
    """The values that all parameter bindings give, the outer ones over the inner, later ones over earlier ones.

    `knows` says whether a component has a variable of a name. Values for names that nothing has are passed over, as the
    standard asks for; a remark says which.
    """
    found = Values()
    _gather(root, knows, found)
    return found


def _gather(element: Element, knows: Callable[[Component, str], bool], found: Values) -> None:
    if isinstance(element, Group):
        for inner in element.elements.values():
            _gather(inner, knows, found)
    for bindings in element.bindings:
        document = bindings.definitions.document
        for node in bindings.node.iterfind("ssd:ParameterBinding", NS):
            unused = [name for name, value in _values(bindings, node) if not _apply(element, name, value, knows, found)]
            if unused:
                told = f"{document.at(node)}: no variable has the names of these values: {', '.join(unused)}"
                document.findings.remarks.append(told)


def _apply(element: Element, name: str, value: Value, knows: Callable[[Component, str], bool], found: Values) -> bool:
    """Give a value to everything in an element that has this name; false where nothing has."""
    if isinstance(element, Component):
        if not knows(element, name):
            return False
        given = found.variables.setdefault(element.path, {})
        given.pop(name, None)  # the order is that in which values are given
        given[name] = value
        return True
    if not isinstance(element, Group):
        return False
    reached = name in element.connectors
    if reached:
        found.connectors[element.port(name)] = value
    for inner in element.elements.values():
        if name.startswith(f"{inner.name}."):
            reached |= _apply(inner, name[len(inner.name) + 1 :], value, knows, found)
    return reached


def _values(bindings: Bindings, node: Node) -> Iterator[tuple[str, Value]]:
    """Names and values of one binding, its prefix and mapping applied."""
    document = bindings.definitions.document
    if (kind := node.get("type") or _SET_TYPE) != _SET_TYPE:
        document.findings.wrong(document.at(node, "parameter binding"), f"the type `{kind}`", _SET_TYPE)
        return
    inline = node.find("ssd:ParameterValues", NS)
    found = _document(bindings, node, VALUES, inline)
    mapping = node.find("ssd:ParameterMapping", NS)
    if found is None:
        return
    prefix = node.get("prefix", "")
    values = {f"{prefix}{name}": value for name, value in _set(*found)}
    if mapping is None:
        yield from values.items()
    elif (kind := mapping.get("type") or _MAPPING_TYPE) != _MAPPING_TYPE:
        document.findings.wrong(document.at(mapping, "parameter mapping"), f"the type `{kind}`", _MAPPING_TYPE)
    elif (entries := _document(bindings, mapping, MAPPING, mapping)) is not None:
        yield from _mapped(*entries, values)


def _document(bindings: Bindings, node: Node, kind: str, inline: Node | None) -> tuple[Document, Node] | None:
    """The parameter set or mapping that an element brings or refers to; None where it cannot be used."""
    document, source = bindings.definitions.document, node.get("source")
    where = document.at(node, local(node))
    if not source:
        found = next((child for child in (() if inline is None else inline) if local(child) == kind), None)
        if found is None:
            document.findings.wrong(where, "neither a source nor a content", f"one of them, a `{kind}`")
            return None
        return (document, found) if is_valid(document, found, kind) else None
    if node.get("sourceBase") == "component":
        read = _inside(bindings, source, where, kind)
    else:
        file = resolve(document, source, where)
        read = None if file is None else read_document(document.package, file, kind)
    return None if read is None else (read, read.root)


def _inside(bindings: Bindings, source: str, where: str, kind: str) -> Document | None:
    """A document inside a component."""
    document, file = bindings.definitions.document, bindings.file
    archive = None
    if file is not None:
        archive = document.findings.attempt(lambda: read(file, {source}, where, "a component that is a zip archive"))
        if archive is None:
            return None
    content = None if archive is None else archive[1].get(source)
    if file is None or content is None:
        document.findings.wrong(where, f"the file `{source}`, which is not in the component", "a file inside it")
        return None
    root = document.findings.attempt(lambda: parse_xml(content, where, "well-formed XML without a DTD"))
    made = None if root is None else Document(document.package, file / source, root)
    return made if made is not None and is_valid(made, made.root, kind) else None


def _set(document: Document, root: Node) -> Iterator[tuple[str, Value]]:
    definitions = Definitions.of(document, root)
    seen: set[str] = set()
    for node in root.iterfind("ssv:Parameters/ssv:Parameter", NS):
        name, where = node.get("name", ""), document.at(node, f"parameter `{node.get('name')}`")
        if name in seen:
            document.findings.breach(where, "a second value", "one value for each name")
        seen.add(name)
        kind = next((child for child in node if "value" in child.attrib or local(child) != "Annotations"), None)
        if kind is None:
            document.findings.wrong(where, "no value", "a type with a value")
            continue
        children = [child for child in kind if local(child) == "Value"]
        texts = tuple(child.get("value", child.text or "") for child in children) or (kind.get("value", ""),)
        origin = node.get("description") or document.path.name
        yield name, Value(texts, declared(definitions, node), origin, Step(where))


def _mapped(document: Document, root: Node, values: Mapping[str, Value]) -> Iterator[tuple[str, Value]]:
    targets: set[str] = set()
    for node in root.iterfind("ssm:MappingEntry", NS):
        source, target = node.get("source", ""), node.get("target", "")
        where = document.at(node, f"{source} -> {target}")
        if source not in values:
            document.findings.breach(where, f"no value `{source}`", choices(values), did_you_mean(source, values))
            continue
        if target in targets:
            document.findings.wrong(where, f"a second value for `{target}`", "one entry for each target")
        targets.add(target)
        step = Step(where, change(document, node), is_true(node.get("suppressUnitConversion")))
        yield target, replace(values[source], step=step)
