"""An FMU file that has been read, with all that its description says."""
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

VALID_FMU: Final = (
    f"an FMU: a zip archive with {MODEL_DESCRIPTION}, FMI 2.0 or 3.0, for Co-Simulation or Model Exchange"
)
"""The part of a message that says what a file should be"""


@dataclass(frozen=True)
class Archive:
    """An FMU file that has been read, and that can be used."""

    path: Path
    version: Version
    description: Any
    """The model description as FMPy reads it"""
    interface: Interface
    references: dict[str, list[int]]
    """Value references of each variable: one per element in FMI 2.0, one in all in FMI 3.0"""
    structural: tuple[str, ...] = ()
    """Structural parameters: those that the lengths of arrays depend on"""
    clocks_of: Mapping[str, frozenset[int]] = field(default_factory=dict[str, frozenset[int]])
    """Value references of the clocks of each clocked variable"""
    remarks: tuple[str, ...] = ()
    """What a user should know of it: the rules of FMI that it breaks, and what it needs"""
    files: frozenset[str] = frozenset()
    """The paths of all files in it"""
    root: Any = None
    """The root element of its model description"""

    @property
    def is_model_exchange(self) -> bool:
        """Whether the importer has to integrate it, because it has no solver of its own."""
        return self.description.coSimulation is None

    @property
    def is_plain_fmi3(self) -> bool:
        """Whether it is FMI 3.0 Co-Simulation, which can be stepped without Event Mode."""
        return self.version == Version.FMI3 and not self.is_model_exchange

    @property
    def interface_type(self) -> Any:
        """The interface type that is used, with its capabilities: Co-Simulation where it has both."""
        return self.description.coSimulation or self.description.modelExchange

    @property
    def only_once(self) -> bool:
        """Whether a process can hold only one instance of it."""
        return bool(self.interface_type.canBeInstantiatedOnlyOncePerProcess)
