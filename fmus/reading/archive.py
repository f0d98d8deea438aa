"""An FMU file that has been read, and what it says of itself."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface

VALID: Final = f"an FMU: a zip archive with {MODEL_DESCRIPTION}, FMI 2.0 or 3.0, for Co-Simulation or Model Exchange"


@dataclass(frozen=True)
class Archive:
    """An FMU file that has been read and understood."""

    path: Path
    version: Version
    description: Any
    interface: Interface
    references: dict[str, list[int]]
    """Value references of each variable: one per element in FMI 2.0, one in all in FMI 3.0"""
    structural: tuple[str, ...] = ()
    """Structural parameters: those that lengths of arrays depend on"""
    clocks_of: Mapping[str, frozenset[int]] = field(default_factory=dict[str, frozenset[int]])
    """Value references of the clocks of each clocked variable"""
    remarks: tuple[str, ...] = ()
    """What a person should know of it: rules of FMI that it breaks, and what it needs"""
    files: frozenset[str] = frozenset()
    """All files in it"""
    root: Any = None
    """The root element of its model description"""

    @property
    def is_model_exchange(self) -> bool:
        """Whether it has to be integrated by a solver, as it brings none of its own."""
        return self.description.coSimulation is None

    @property
    def is_plain_fmi3(self) -> bool:
        """Whether it is FMI 3.0 Co-Simulation, which can be stepped without Event Mode."""
        return self.version == Version.FMI3 and not self.is_model_exchange

    @property
    def kind(self) -> Any:
        """The interface type that is used, with its capabilities: Co-Simulation where there is a choice."""
        return self.description.coSimulation or self.description.modelExchange

    @property
    def only_once(self) -> bool:
        """Whether a process can hold no more than one instance."""
        return bool(self.kind.canBeInstantiatedOnlyOncePerProcess)
