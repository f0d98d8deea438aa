"""The elements that the systems of an SSP consist of: components, systems and signal dictionary references."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from orchestrator.ssp.connections import Connector, ConnectorPath, SspConnection
from orchestrator.ssp.types import Definitions
from orchestrator.ssp.vocabulary import ANY_IMPLEMENTATION
from orchestrator.ssp.xml import Node


@dataclass(frozen=True)
class ParameterBindings:
    """The parameter bindings of an element, as they stand in its file.

    Attributes:
        definitions: The definitions of that file.
        node: The element `ParameterBindings`.
        file: The file of the component that they belong to; None for a system and for a block.
    """

    definitions: Definitions
    node: Node
    file: Path | None


@dataclass(eq=False)
class SystemElement:
    """An element of a system: a component, a system, or a signal dictionary reference.

    Attributes:
        name: Its name in its system.
        path: The names of the systems that contain it, without the outermost, and its own.
        where: The file and the line, for messages.
        connectors: Its connectors, by name.
        bindings: Its parameter bindings; those that stand further out come later.
    """

    name: str
    path: tuple[str, ...]
    where: str
    connectors: dict[str, Connector] = field(default_factory=dict[str, Connector])
    bindings: list[ParameterBindings] = field(default_factory=list[ParameterBindings])

    @property
    def may_have_others(self) -> bool:
        """Whether the file may leave out connectors that a lenient reader takes to be there."""
        return False

    def connector_path(self, connector: str) -> ConnectorPath:
        """The path of a connector in the whole structure."""
        return self.path, connector


@dataclass(eq=False)
class Component(SystemElement):
    """An FMU, a mapping file, or a block of this program.

    Attributes:
        file: The FMU or the mapping file; None for a block, and for a file that is missing.
        file_where: That file in the SSP, as messages name it.
        block: The source of a block; empty for a file.
        implementation: The FMI type that the SSP asks for.
        step_size: The step [s] that the annotation of OSP suggests.
    """

    file: Path | None = None
    file_where: str = ""
    block: str = ""
    implementation: str = ANY_IMPLEMENTATION
    step_size: float | None = None

    @property
    def may_have_others(self) -> bool:
        """A component has all the variables of its FMU, whichever of them the file lists."""
        return True


@dataclass(eq=False)
class SspSystem(SystemElement):
    """A system: elements, and the connections between them."""

    elements: dict[str, SystemElement] = field(default_factory=dict[str, SystemElement])
    connections: list[SspConnection] = field(default_factory=list[SspConnection])

    def walk(self) -> Iterator[SystemElement]:
        """This system and all elements in it, including those of the systems in it."""
        yield self
        for element in self.elements.values():
            if isinstance(element, SspSystem):
                yield from element.walk()
            else:
                yield element


@dataclass(eq=False)
class SignalDictionaryReference(SystemElement):
    """A reference to a signal dictionary, whose signals are its connectors."""

    dictionary: tuple[str, ...] = ()

    def connector_path(self, connector: str) -> ConnectorPath:
        """The signal of the dictionary, which all references to it share."""
        return self.dictionary, connector
