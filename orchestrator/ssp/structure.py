"""The structure that an SSP describes: systems in systems, their components, connectors and connections.

Components that are packages or descriptions themselves are systems here, read from their own files.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from components.interfaces.problem import choices, did_you_mean
from orchestrator.ssp.archive import Document, is_valid, open_package, read_document, resolve
from orchestrator.ssp.connections import Connector, Port, Wire, wire
from orchestrator.ssp.rules import (
    BLOCK_TYPE,
    DEFINITION_TYPE,
    DICTIONARY,
    FMU_TYPE,
    MAPPING_TYPE,
    NS,
    PACKAGE_TYPE,
    Node,
    local,
)
from orchestrator.ssp.types import Definitions, declared, number

_TYPES: Final = (FMU_TYPE, PACKAGE_TYPE, DEFINITION_TYPE, BLOCK_TYPE, MAPPING_TYPE)
_DEEPEST: Final = 50
"""Systems in systems."""


@dataclass(frozen=True)
class Bindings:
    """The parameter bindings of an element, as they stand in its file."""

    definitions: Definitions
    node: Node
    file: Path | None
    """The component that they belong to"""


@dataclass(eq=False)
class Element:
    """A component, a system, or a place where signals of a dictionary are reached."""

    name: str
    path: tuple[str, ...]
    """Names of the systems it lies in, without the outermost, and its own"""
    where: str
    connectors: dict[str, Connector] = field(default_factory=dict[str, Connector])
    bindings: list[Bindings] = field(default_factory=list[Bindings])

    def port(self, connector: str) -> Port:
        """Where a connector stands in the whole."""
        return self.path, connector


@dataclass(eq=False)
class Component(Element):
    """An FMU, or a block of ours."""

    file: Path | None = None
    block: str = ""
    implementation: str = "any"
    step_size: float | None = None
    """[s] as OSP's annotation hints at it"""


@dataclass(eq=False)
class Group(Element):
    """A system: elements and the connections between them."""

    elements: dict[str, Element] = field(default_factory=dict[str, Element])
    wires: list[Wire] = field(default_factory=list[Wire])
    dictionaries: dict[str, Port] = field(default_factory=dict[str, Port])

    def walk(self) -> Iterator[Element]:
        """All elements in it, those of systems in it too, and itself."""
        yield self
        for element in self.elements.values():
            if isinstance(element, Group):
                yield from element.walk()
            else:
                yield element


@dataclass(eq=False)
class Reference(Element):
    """A place where the signals of a dictionary are reached."""

    dictionary: tuple[str, ...] = ()

    def port(self, connector: str) -> Port:
        """The signal of the dictionary, which all its references share."""
        return self.dictionary, connector


@dataclass(frozen=True)
class _Place:
    """Where an element is read: its file, the systems around it, and what is being read (to see a circle)."""

    definitions: Definitions
    path: tuple[str, ...] = ()
    dictionaries: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    stack: tuple[tuple[str, str], ...] = ()

    @property
    def document(self) -> Document:
        return self.definitions.document

    def inside(self, name: str) -> _Place:
        return replace(self, path=(*self.path, name))


def read_structure(document: Document) -> Group | None:
    """The outermost system of a description; None where there is none: the findings say why."""
    key = (f"{document.path.relative_to(document.package.folder)}", str(document.path))
    return _description(document, (key,))


def _description(
    document: Document, stack: tuple[tuple[str, str], ...], path: tuple[str, ...] = (), name: str = ""
) -> Group | None:
    node = document.root.find("ssd:System", NS)
    if node is None:
        document.findings.wrong(document.at(document.root), "no system", "an element `System`")
        return None
    return _system(node, _Place(Definitions.of(document, document.root), path, stack=stack), name)


def _system(node: Node, place: _Place, name: str) -> Group:
    made = Group(name or node.get("name", ""), place.path, place.document.at(node))
    _fill(made, node, place, None)
    place = replace(place, dictionaries={**place.dictionaries, **_dictionaries(node, place)})
    for child in node.iterfind("ssd:Elements/*", NS):
        label = child.get("name", "")
        if label in made.elements:
            place.document.findings.wrong(place.document.at(child), f"a second element `{label}`", "names of their own")
        elif (element := _element(child, place.inside(label), label)) is not None:
            made.elements[label] = element
    for child in node.iterfind("ssd:Connections/ssd:Connection", NS):
        if (found := wire(place.document, child, made, made.elements)) is not None:
            made.wires.append(found)
    return made


def _fill(made: Element, node: Node, place: _Place, file: Path | None) -> None:
    """Connectors and parameter bindings, which all kinds of elements have."""
    document = place.document
    for child in node.iterfind("ssd:Connectors/ssd:Connector", NS):
        name, kind = child.get("name", ""), child.get("kind", "")
        if name in made.connectors:
            document.findings.wrong(document.at(child), f"a second connector `{name}`", "names of their own")
        made.connectors[name] = Connector(name, kind, declared(place.definitions, child), document.at(child))
    if (bindings := node.find("ssd:ParameterBindings", NS)) is not None:
        made.bindings.append(Bindings(place.definitions, bindings, file))


def _element(node: Node, place: _Place, name: str) -> Element | None:
    kind = local(node)
    if kind == "System":
        return _system(node, place, name)
    if kind == "Component":
        return _component(node, place, name)
    if kind == "SignalDictionaryReference":
        wanted = node.get("dictionary", "")
        if wanted in place.dictionaries:
            made = Reference(name, place.path, place.document.at(node), dictionary=place.dictionaries[wanted])
            _fill(made, node, place, None)
            return made
        close = did_you_mean(wanted, place.dictionaries)
        where = place.document.at(node, name)
        place.document.findings.wrong(where, f"the signal dictionary `{wanted}`", choices(place.dictionaries), close)
    return None


def _component(node: Node, place: _Place, name: str) -> Element | None:
    document, where = place.document, place.document.at(node, f"component `{name}`")
    kind, source = node.get("type") or FMU_TYPE, node.get("source", "")
    if kind not in _TYPES:
        document.findings.wrong(where, f"the type `{kind}`", choices(_TYPES[:3]))
        return None
    if not source:
        document.findings.wrong(where, "no source", "the path of an FMU or SSP in the archive", "Give it one.")
        return None
    if kind == BLOCK_TYPE:
        made = Component(name, place.path, where, block=source)
    elif kind in {FMU_TYPE, MAPPING_TYPE}:
        file = resolve(document, source, where)
        made = Component(name, place.path, where, file=file, implementation=node.get("implementation") or "any")
        hint = node.find(".//{*}StepSizeHint")
        made.step_size = number(document, hint, "value") if hint is not None else None
    else:
        return _system_component(node, place, kind, where)
    _fill(made, node, place, made.file)
    return made


def _system_component(node: Node, place: _Place, kind: str, where: str) -> Group | None:
    """A component that is a system of its own: another one of this file, another description, or another package."""
    document, source, name = place.document, node.get("source", ""), node.get("name", "")
    entered = _entered(document, source, where, place)
    if entered is None:
        return None
    place, file = entered
    if source.startswith("#"):
        found = next((n for n in document.root.iter(f"{{{NS['ssd']}}}System") if n.get("id") == source[1:]), None)
        if found is None:
            document.findings.wrong(where, f"the system `{source}`, which is not there", "the id of a system")
            return None
        made = _system(found, place, name)
    else:
        inner = _opened(document, file, source, kind)
        made = None if inner is None else _description(inner, place.stack, place.path, name)
    if made is not None:
        outer = Element(name, place.path, where)
        _fill(outer, node, place, file)
        for connector in outer.connectors.keys() - made.connectors.keys():
            valid = f"a connector of the system: {choices(made.connectors)}"
            document.findings.breach(where, f"the connector `{connector}`", valid)
        made.bindings += outer.bindings
    return made


def _entered(document: Document, source: str, where: str, place: _Place) -> tuple[_Place, Path] | None:
    """The place inside a component that is a system; None where its file is missing, or is being read already."""
    file = document.path if source.startswith("#") else resolve(document, source, where)
    if file is None:
        return None
    content = hashlib.sha256(file.read_bytes()).hexdigest() if file.suffix == ".ssp" else str(file)
    key = (source, content + (source if source.startswith("#") else ""))
    if key[1] in {known for _, known in place.stack} or len(place.stack) > _DEEPEST:
        chain = " -> ".join(name for name, _ in (*place.stack, key))
        document.findings.wrong(where, f"an SSP that includes itself: {chain}", "systems without a circle")
        return None
    return replace(place, stack=(*place.stack, key)), file


def _opened(document: Document, file: Path, source: str, kind: str) -> Document | None:
    """The description that a component means."""
    if kind == DEFINITION_TYPE:
        return read_document(document.package, file)
    package = document.findings.attempt(
        lambda: open_package(file, f"{document.package.where}, {source}", document.findings)
    )
    if package is None:
        return None
    path = package.folder / (source.partition("#")[2] or "SystemStructure.ssd")
    if not path.is_file():
        document.findings.wrong(f"{package.where}", f"no {path.name}", "an SSP: a zip archive with SystemStructure.ssd")
        return None
    return read_document(package, path)


def _dictionaries(node: Node, place: _Place) -> dict[str, tuple[str, ...]]:
    """The signal dictionaries of a system, as paths that no element has."""
    found: dict[str, tuple[str, ...]] = {}
    for child in node.iterfind("ssd:SignalDictionaries/ssd:SignalDictionary", NS):
        document, source = place.document, child.get("source")
        where = document.at(child, f"signal dictionary `{child.get('name')}`")
        found[child.get("name", "")] = (*place.path, f"\0{child.get('name')}")
        if source:
            file = resolve(document, source, where)
            if file is not None:
                read_document(document.package, file, DICTIONARY)
        else:
            for inline in child:
                if local(inline) == DICTIONARY:
                    is_valid(document, inline, DICTIONARY)
    return found
