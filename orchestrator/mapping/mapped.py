"""FMUs of other makers in a socket: as they are where they have its interface, else behind a mapping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, final

from typing_extensions import override

from components.interfaces.problem import Problem, raise_if_any
from components.interfaces.socket import Socket
from fmus.unit_interface import Interface, SuggestedExperiment
from fmus.units.mapped_unit import MappedUnit
from fmus.units.unit import Unit
from orchestrator.mapping.fitting import fit
from orchestrator.mapping.fitting_result import Fitting
from orchestrator.mapping.mapping_file import MappingFile, written
from orchestrator.system.source import Fmu, SourceDescription, UnitSource


@final
@dataclass(frozen=True)
class Mapped(UnitSource):
    """An FMU behind the interface of a socket: its signals are those of the socket, whatever the FMU calls them."""

    fmu: Fmu
    fitting: Fitting

    @property
    def parameters(self) -> Mapping[str, Any]:  # type: ignore[override] - read through to the FMU, as all of it is
        """The values that the FMU is given."""
        return self.fmu.parameters

    @property
    @override
    def interface(self) -> Interface:
        """The socket's, and what the FMU shows beyond it."""
        return self.fitting.interface

    @override
    def with_parameters(self, parameters: Mapping[str, Any]) -> Mapped:
        return replace(self, fmu=self.fmu.with_parameters(parameters))

    @override
    def in_own_process(self, patience: float) -> Mapped:
        return replace(self, fmu=self.fmu.in_own_process(patience))

    @override
    def describe(self) -> SourceDescription:
        return self.fmu.describe()

    @property
    @override
    def suggested(self) -> SuggestedExperiment:
        return self.fmu.suggested

    @override
    def mapping_text(self, file: str | None = None) -> str:
        return written(self.fitting.mapping, file)

    @override
    def open(self, name: str) -> Unit:
        return MappedUnit(name, self.interface, self.fmu.open(name), self.fitting.adaptation)

    @override
    def for_other_tools(self) -> UnitSource:
        """The FMU itself, where its mapping only adds to what its file says of it."""
        return self.fmu if self.fitting.plain else self

    @override
    def foreign_problem(self, unit: str) -> Problem:
        found = f"`{self.interface.kind}` behind a mapping, which other tools do not read"
        return Problem(unit, found, "an FMU with the names and units of its socket", "Export it so, or run it here.")

    @override
    def single_instance(self) -> Path | None:
        return self.fmu.single_instance()


def fitted(
    name: str, socket: Socket, fmu: Fmu, mapping: MappingFile | None = None
) -> tuple[Fmu | Mapped, tuple[Problem, ...], tuple[str, ...]]:
    """Fit an FMU to a socket.

    Args:
        name: The unit's name, for messages.
        socket: The socket it is to fill.
        fmu: The FMU, with its parameters.
        mapping: What a mapping file says of it; without one, its names decide.

    Returns:
        The source for the unit, what keeps it from fitting, and the decisions that no mapping file gave.
    """
    fitting = fit(name, socket, fmu.interface, str(fmu.path), mapping)
    source = Mapped(fmu, fitting) if fitting.needed else fmu
    return source, fitting.problems, fitting.remarks


def mapped(name: str, socket: Socket, fmu: Fmu, mapping: MappingFile | None = None) -> Fmu | Mapped:
    """Make an FMU a unit of a system that is put together in Python.

    Args:
        name: The unit's name.
        socket: The socket that it is to fill.
        fmu: The FMU, with its parameters.
        mapping: What a mapping file says of it; without one, its names decide.

    Raises:
        RequestError: The FMU does not fit; the error has all reasons.
    """
    source, problems, _ = fitted(name, socket, fmu, mapping)
    raise_if_any(problems)
    return source
