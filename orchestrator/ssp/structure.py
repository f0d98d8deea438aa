"""Reading the structure that an SSP describes: systems in systems, their components, connectors and connections.

A component that is itself a package or a description is a system here, read from its own file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from components.interfaces.problem import choices, did_you_mean
from fmus.toolchain.file_names import path_problem, shown_name
from fmus.toolchain.limits import DEEPEST_SYSTEMS
from orchestrator.ssp.archive import VALID_PACKAGE, Document, conforms, digest, open_package, read_document, resolve_uri
from orchestrator.ssp.connections import Connector, read_connection
from orchestrator.ssp.system_elements import (
    Component,
    ParameterBindings,
    SignalDictionaryReference,
    SspSystem,
    SystemElement,
)
from orchestrator.ssp.types import Definitions, number, read_type
from orchestrator.ssp.vocabulary import (
    ANY_IMPLEMENTATION,
    BLOCK_TYPE,
    DEFINITION_TYPE,
    DESCRIPTION_FILE,
    FMU_TYPE,
    MAPPING_TYPE,
    PACKAGE_SUFFIX,
    PACKAGE_TYPE,
    SSD,
    Attribute,
    Tag,
)
from orchestrator.ssp.xml import Node, local_name, path_of, qualified

_STANDARD_TYPES: Final = (FMU_TYPE, PACKAGE_TYPE, DEFINITION_TYPE)


@dataclass(frozen=True)
class _Context:
    """What surrounds an element that is being read.

    Attributes:
        definitions: Its file, and what that defines.
        path: The names of the systems that contain it, and its own.
        dictionaries: The paths of the signal dictionaries within reach, by name.
        sources: The descriptions that are being read, by source and identity, outermost first.
    """

    definitions: Definitions
    path: tuple[str, ...] = ()
    dictionaries: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    sources: tuple[tuple[str, str], ...] = ()

    @property
    def document(self) -> Document:
        return self.definitions.document

    def inside(self, name: str) -> _Context:
        return replace(self, path=(*self.path, name))


def read_structure(document: Document) -> SspSystem | None:
    """The outermost system of a description; None where the findings say that there is none."""
    source = (f"{document.path.relative_to(document.package.folder)}", str(document.path))
    return _description(document, (source,))


def _description(
    document: Document, sources: tuple[tuple[str, str], ...], path: tuple[str, ...] = (), name: str = ""
) -> SspSystem | None:
    node = document.root.find(qualified(SSD, Tag.SYSTEM))
    if node is None:
        document.findings.add_problem(document.at(document.root), "no system", f"an element `{Tag.SYSTEM}`")
        return None
    return _system(node, _Context(Definitions.of(document, document.root), path, sources=sources), name)


def _system(node: Node, context: _Context, name: str) -> SspSystem:
    document = context.document
    system = SspSystem(name or node.get(Attribute.NAME, ""), context.path, document.at(node))
    _add_connectors_and_bindings(system, node, context, None)
    context = replace(context, dictionaries={**context.dictionaries, **_dictionaries(node, context)})
    for child in node.iterfind(f"{qualified(SSD, Tag.ELEMENTS)}/*"):
        label = child.get(Attribute.NAME, "")
        if label in system.elements:
            document.findings.add_problem(document.at(child), f"a second element `{label}`", "names of their own")
        elif (element := _element(child, context.inside(label), label)) is not None:
            system.elements[label] = element
    for child in node.iterfind(path_of(SSD, Tag.CONNECTIONS, Tag.CONNECTION)):
        if (connection := read_connection(document, child, system, system.elements)) is not None:
            system.connections.append(connection)
    return system


def _add_connectors_and_bindings(element: SystemElement, node: Node, context: _Context, file: Path | None) -> None:
    """Add what elements of all kinds have."""
    document = context.document
    for child in node.iterfind(path_of(SSD, Tag.CONNECTORS, Tag.CONNECTOR)):
        name, kind = child.get(Attribute.NAME, ""), child.get(Attribute.KIND, "")
        where = document.at(child)
        if name in element.connectors:
            document.findings.add_problem(where, f"a second connector `{name}`", "names of their own")
        element.connectors[name] = Connector(name, kind, read_type(context.definitions, child), where)
    if (bindings := node.find(qualified(SSD, Tag.PARAMETER_BINDINGS))) is not None:
        element.bindings.append(ParameterBindings(context.definitions, bindings, file))


def _element(node: Node, context: _Context, name: str) -> SystemElement | None:
    kind = local_name(node)
    context.document.findings.expansion.add_element(context.document.at(node))
    if kind == Tag.SYSTEM:
        return _system(node, context, name)
    if kind == Tag.COMPONENT:
        return _component(node, context, name)
    if kind == Tag.SIGNAL_DICTIONARY_REFERENCE:
        return _dictionary_reference(node, context, name)
    return None


def _dictionary_reference(node: Node, context: _Context, name: str) -> SignalDictionaryReference | None:
    document, dictionary_name = context.document, node.get(Attribute.DICTIONARY, "")
    if dictionary_name not in context.dictionaries:
        close = did_you_mean(dictionary_name, context.dictionaries)
        unknown = f"the signal dictionary `{dictionary_name}`"
        document.findings.add_problem(document.at(node, name), unknown, choices(context.dictionaries), close)
        return None
    dictionary = context.dictionaries[dictionary_name]
    reference = SignalDictionaryReference(name, context.path, document.at(node), dictionary=dictionary)
    _add_connectors_and_bindings(reference, node, context, None)
    return reference


def _component(node: Node, context: _Context, name: str) -> SystemElement | None:
    document = context.document
    where = document.at(node, f"component `{name}`")
    kind, source = node.get(Attribute.TYPE) or FMU_TYPE, node.get(Attribute.SOURCE, "")
    if kind not in (*_STANDARD_TYPES, BLOCK_TYPE, MAPPING_TYPE):
        document.findings.add_problem(where, f"the type `{kind}`", choices(_STANDARD_TYPES))
        return None
    if not source:
        valid = "the path of an FMU or SSP in the archive"
        document.findings.add_problem(where, "no source", valid, "Give it one.")
        return None
    if kind == BLOCK_TYPE:
        component = Component(name, context.path, where, block=source)
    elif kind in {FMU_TYPE, MAPPING_TYPE}:
        file, package = resolve_uri(document, source, where), document.package
        component = Component(name, context.path, where, file=file)
        component.file_where = "" if file is None else f"{package.where}, {file.relative_to(package.folder).as_posix()}"
        component.implementation = node.get(Attribute.IMPLEMENTATION) or ANY_IMPLEMENTATION
        hint = node.find(f".//{{*}}{Tag.STEP_SIZE_HINT}")
        component.step_size = None if hint is None else number(document, hint, Attribute.VALUE)
    else:
        return _system_of_component(node, context, kind, where)
    _add_connectors_and_bindings(component, node, context, component.file)
    return component


def _system_of_component(node: Node, context: _Context, kind: str, where: str) -> SspSystem | None:
    """A component that is a system of its own: another one of this file, another description, or another package."""
    document, source, name = context.document, node.get(Attribute.SOURCE, ""), node.get(Attribute.NAME, "")
    document.findings.expansion.add_system(where)
    entered = _entered(document, source, where, context)
    if entered is None:
        return None
    context, file = entered
    if source.startswith("#"):
        systems = document.root.iter(qualified(SSD, Tag.SYSTEM))
        inner_node = next((n for n in systems if n.get(Attribute.ID) == source[1:]), None)
        if inner_node is None:
            missing = f"the system `{source}`, which is not there"
            document.findings.add_problem(where, missing, "the id of a system")
            return None
        system = _system(inner_node, context, name)
    else:
        inner = _inner_description(document, file, source, kind)
        system = None if inner is None else _description(inner, context.sources, context.path, name)
    if system is not None:
        outer = SystemElement(name, context.path, where)
        _add_connectors_and_bindings(outer, node, context, file)
        for connector in outer.connectors.keys() - system.connectors.keys():
            valid = f"a connector of the system: {choices(system.connectors)}"
            document.findings.add_breach(where, f"the connector `{connector}`", valid)
        system.bindings += outer.bindings
    return system


def _entered(document: Document, source: str, where: str, context: _Context) -> tuple[_Context, Path] | None:
    """The context inside a component that is a system; None where its file is missing, or is being read already."""
    file = document.path if source.startswith("#") else resolve_uri(document, source, where)
    if file is None:
        return None
    content = digest(file) if file.suffix == PACKAGE_SUFFIX else str(file)
    entry = (source, content + (source if source.startswith("#") else ""))
    if entry[1] in {identity for _, identity in context.sources} or len(context.sources) > DEEPEST_SYSTEMS:
        chain = " -> ".join(name for name, _ in (*context.sources, entry))
        document.findings.add_problem(where, f"an SSP that includes itself: {chain}", "systems without a circle")
        return None
    return replace(context, sources=(*context.sources, entry)), file


def _inner_description(document: Document, file: Path, source: str, kind: str) -> Document | None:
    """The description that a component refers to."""
    if kind == DEFINITION_TYPE:
        return read_document(document.package, file)
    where = f"{document.package.where}, {source}"
    package = document.findings.attempt(lambda: open_package(file, where, document.findings))
    if package is None:
        return None
    name = source.partition("#")[2] or DESCRIPTION_FILE
    if path_problem(name) or not (path := package.folder / name).is_file():
        document.findings.add_problem(package.where, f"no {shown_name(name)}", VALID_PACKAGE)
        return None
    return read_document(package, path)


def _dictionaries(node: Node, context: _Context) -> dict[str, tuple[str, ...]]:
    """The signal dictionaries of a system by name, with paths that no element has."""
    document, paths = context.document, dict[str, tuple[str, ...]]()
    for child in node.iterfind(path_of(SSD, Tag.SIGNAL_DICTIONARIES, Tag.SIGNAL_DICTIONARY)):
        name, source = child.get(Attribute.NAME), child.get(Attribute.SOURCE)
        paths[name or ""] = (*context.path, f"\0{name}")
        if source:
            file = resolve_uri(document, source, document.at(child, f"signal dictionary `{name}`"))
            if file is not None:
                read_document(document.package, file, Tag.SIGNAL_DICTIONARY)
        else:
            for inline in child:
                if local_name(inline) == Tag.SIGNAL_DICTIONARY:
                    conforms(document, inline, Tag.SIGNAL_DICTIONARY)
    return paths
