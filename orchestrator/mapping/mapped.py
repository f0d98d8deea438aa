"""FMUs of other makers in a socket: as they are where they have its interface, else behind a mapping."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self, final

from typing_extensions import override

from components.interfaces.arguments import checked_arguments
from components.interfaces.problem import Problem, raise_if_any
from components.interfaces.progress import Progress
from components.interfaces.record import Variable
from components.interfaces.socket import Socket
from components.interfaces.sockets import SOCKETS
from fmus.unit_interface import Interface, SuggestedExperiment
from fmus.units.mapped_unit import MappedUnit
from fmus.units.unit import Unit
from orchestrator.mapping.adapted_interface import through_step_of
from orchestrator.mapping.fitting import fit
from orchestrator.mapping.fitting_result import Fitting
from orchestrator.mapping.mapping_file import Amount, MappingFile, written
from orchestrator.system.source import Fmu, UnitSource
from orchestrator.system.source_description import SourceDescription


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
    def with_parameters(self, parameters: Mapping[str, Any]) -> Self:
        fmu = self.fmu.with_parameters(parameters)
        return self._fitted_again(fmu, self.fitting.mapping) if self.structural else replace(self, fmu=fmu)

    def _fitted_again(self, fmu: Fmu, mapping: MappingFile) -> Self:
        fitting = fit(fmu.path.stem, SOCKETS[mapping.socket or ""], fmu.interface, fmu.named_as, mapping)
        raise_if_any(fitting.problems)
        return replace(self, fmu=fmu, fitting=fitting)

    @override
    def in_own_process(self, patience: float) -> Mapped:
        return replace(self, fmu=self.fmu.in_own_process(patience))

    @override
    def in_this_process(self) -> Mapped:
        return replace(self, fmu=self.fmu.in_this_process())

    @override
    def describe(self) -> SourceDescription:
        return self.fmu.describe()

    @override
    def make_ready(self, progress: Progress) -> None:
        self.fmu.make_ready(progress)

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
        return self.bare if self.fitting.plain else self

    @property
    def bare(self) -> Fmu:
        """The FMU without its mapping, which acts in time as it does in the socket."""
        outputs = through_step_of(self.fmu.interface, self.interface, self.fitting.adaptation)
        return self.fmu.acting_through_step(outputs)

    @override
    def foreign_problem(self, unit: str) -> Problem:
        found = f"`{self.interface.kind}` behind a mapping, which other tools do not read"
        return Problem(unit, found, "an FMU with the names and units of its socket", "Export it so, or run it here.")

    @property
    @override
    def has_own_values(self) -> bool:
        return True

    @property
    @override
    def structural(self) -> tuple[str, ...]:
        return self.fmu.structural

    @property
    @override
    def free_inputs(self) -> list[Variable]:
        adaptation = self.fitting.adaptation
        links = (*adaptation.inputs, *(rate.rate for rate in adaptation.rates))
        driven = {name for link in links for name, _ in link.theirs}
        return [v for v in self.fmu.interface.inputs if v.name not in driven]

    @override
    def holding(self, inputs: Mapping[str, Any]) -> Self:
        return self._fitted_again(self.fmu, holding(self.fitting.mapping, inputs, self.fmu.interface))

    @override
    def declares(self, name: str) -> bool:
        return self.fmu.declares(name)

    @property
    @override
    def observable(self) -> Mapping[str, str]:
        """Those of the FMU, without the names that the socket's signals have."""
        ours = {v.name for v in self.interface.outputs}
        return {name: causality for name, causality in self.fmu.observable.items() if name not in ours}

    @override
    def observing(self, names: Sequence[str]) -> Mapped:
        fmu = self.fmu.observing(names)
        observed = fmu.interface.observed
        shown = {v.name for v in self.interface.outputs}
        passed_on = [name for name in self.fitting.adaptation.passed_on if name in shown] + [v.name for v in observed]
        adaptation = replace(self.fitting.adaptation, passed_on=tuple(passed_on))
        interface = replace(self.interface, observed=observed)
        return replace(self, fmu=fmu, fitting=replace(self.fitting, interface=interface, adaptation=adaptation))

    @override
    def single_instance(self) -> Path | None:
        return self.fmu.single_instance()


def holding(mapping: MappingFile, values: Mapping[str, Any], theirs: Interface) -> MappingFile:
    """A mapping in which inputs of the FMU that no signal drives hold other values.

    Args:
        mapping: The mapping.
        values: The values, by the name of the input.
        theirs: The interface of the FMU.
    """
    units = {v.name: v.quantity.unit for v in theirs.inputs}
    held = {name: Amount(value, units[name]) for name, value in values.items()}
    return replace(mapping, constants={**mapping.constants, **held})


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
    fitting = fit(name, socket, fmu.interface, fmu.named_as, mapping)
    source = Mapped(fmu, fitting) if fitting.needed else fmu
    return source, fitting.problems, fitting.remarks


@checked_arguments
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
