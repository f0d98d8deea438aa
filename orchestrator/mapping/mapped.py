"""FMUs of other makers in a socket: as they are where they fit to the letter, else behind a mapping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from components.interfaces.problem import Problem, raise_if_any
from components.interfaces.socket import Socket
from fmus.unit_interface import Interface
from fmus.units.mapped_unit import MappedUnit
from fmus.units.unit import Unit
from orchestrator.mapping.fitting import Fitting, fit
from orchestrator.mapping.mapping_file import MappingFile, written
from orchestrator.system.source import Fmu, Source


@dataclass(frozen=True)
class Mapped:
    """An FMU behind the interface of a socket. Its signals are those of the socket, whatever the FMU calls them."""

    fmu: Fmu
    fitting: Fitting

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Those of the FMU that are given."""
        return self.fmu.parameters

    @property
    def interface(self) -> Interface:
        """The socket's, and what the FMU shows beyond it."""
        return self.fitting.interface

    @property
    def text(self) -> str:
        """The whole mapping as TOML."""
        return written(self.fitting.mapping)

    def make(self, name: str) -> Unit:
        """The running unit."""
        return MappedUnit(name, self.interface, self.fmu.make(name), self.fitting.adaptation)


def fmu_of(source: Source) -> Fmu | None:
    """The FMU that a unit is made from; None for a block of this process."""
    fmu = source.fmu if isinstance(source, Mapped) else source
    return fmu if isinstance(fmu, Fmu) else None


def for_others(source: Source) -> Source:
    """What another tool is given: the FMU itself, where its mapping only adds to what its file says of it."""
    return source.fmu if isinstance(source, Mapped) and source.fitting.plain else source


def fitted(
    name: str, socket: Socket, fmu: Fmu, mapping: MappingFile | None = None
) -> tuple[Fmu | Mapped, tuple[Problem, ...], tuple[str, ...]]:
    """An FMU for a socket, what keeps it from fitting, and what was decided without being told."""
    found = fit(name, socket, fmu.interface, str(fmu.path), mapping)
    source = Mapped(fmu, found) if found.needed else fmu
    return source, found.problems, found.remarks


def mapped(name: str, socket: Socket, fmu: Fmu, mapping: MappingFile | None = None) -> Fmu | Mapped:
    """An FMU as a unit of a system of your own. Raises `RequestError` with all that keeps it from fitting."""
    source, problems, _ = fitted(name, socket, fmu, mapping)
    raise_if_any(problems)
    return source
