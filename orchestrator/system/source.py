"""Unit sources: the blocks and files that units are made from, with the parameter values that they are given."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Self, final

from typing_extensions import override

from components.interfaces.arguments import check_fields, checked_arguments, names_told
from components.interfaces.block import Block
from components.interfaces.problem import Problem
from components.interfaces.progress import Progress
from components.interfaces.record import Variable
from fmus.export.own_builds import is_own_build
from fmus.reading.archive import Archive, InterfaceType
from fmus.reading.kept_files import sharing
from fmus.reading.library import compile_beforehand
from fmus.reading.observation import observable, observing
from fmus.reading.opening import open_fmu
from fmus.toolchain.limits import PATIENCE
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface, SuggestedExperiment
from fmus.units.block_unit import BlockUnit, interface_of
from fmus.units.make import fmu_unit
from fmus.units.unit import Unit
from orchestrator.system.source_description import SourceDescription
from orchestrator.system.unit_source import UnitSource

_CAUSALITIES: Final = {
    "inputs": ("input",),
    "outputs": ("output",),
    "parameters": ("parameter", "structuralParameter"),
    "initials": ("output", "local", "calculatedParameter"),
}
"""The FMI causalities of the variables in each list of `Interface`."""


@final
@dataclass(frozen=True)
class InProcess(UnitSource):
    """A block that runs in this process, with its parameter values."""

    block: type[Block[Any, Any, Any]]
    parameters: Mapping[str, Any]

    @property
    @override
    def interface(self) -> Interface:
        return interface_of(self.block)

    @override
    def with_parameters(self, parameters: Mapping[str, Any]) -> Self:
        return replace(self, parameters=parameters)

    @override
    def describe(self) -> SourceDescription:
        return SourceDescription(self.interface.kind)

    @override
    def open(self, name: str) -> Unit:
        return BlockUnit(name, self.block)

    @override
    def foreign_problem(self, unit: str) -> Problem:
        found = f"`{self.interface.kind}`, a block that runs in this process only"
        return Problem(unit, found, "a block that becomes C, or an FMU", f"Choose another with --{unit}.")


@final
@names_told
@dataclass(frozen=True)
class Fmu(UnitSource):
    """An FMU file, with the parameter values that differ from its own start values.

    Args:
        path: The file.
        parameters: Values by name.
        interface_type: The interface type that is used; Co-Simulation, where the file has it, if not given.
        lenient: Whether the file may be run although it breaks rules of FMI, which `archive.remarks` lists.
        isolated: The time [s] that one call may take in a process of its own. Without it, an FMU that was built here
            runs in this process, and any other in a process of its own with the usual time.
        in_process: Whether it runs in this process whoever has built it.
        known: The content of the file, where it has been read before and is still valid.
        where: The file, as messages name it, for one that was taken from an SSP or built of a Modelica file; its path,
            if not given.
        through_step: Outputs that inputs reach through a step only, whatever the file says of them.
    """

    path: Path
    parameters: Mapping[str, Any] = field(default_factory=dict[str, Any])
    lenient: bool = False
    isolated: float | None = None
    in_process: bool = False
    known: Archive | None = field(default=None, repr=False, compare=False)
    interface_type: InterfaceType | None = None
    where: str = field(default="", compare=False)
    through_step: frozenset[str] = frozenset()  # type: ignore[override] - a field here

    def __post_init__(self) -> None:
        if isinstance(self.path, str):
            object.__setattr__(self, "path", Path(self.path))
        check_fields(self)

    @property
    def named_as(self) -> str:
        """The file, as messages name it."""
        return self.where or str(self.path)

    @cached_property
    def archive(self) -> Archive:
        """The content of the file, read and checked. Raises `RequestError`."""
        found = self.known or open_fmu(
            Path(self.path),
            self.parameters,
            lenient=self.lenient,
            interface_type=self.interface_type,
            where=self.named_as,
        )
        if not self.through_step:
            return found
        return replace(found, interface=found.interface.acting_through_step(self.through_step))

    @property
    @override
    def interface(self) -> Interface:
        return self.archive.interface

    @override
    def with_parameters(self, parameters: Mapping[str, Any]) -> Self:
        # Structural parameters determine the lengths of arrays, so the file has to be read again.
        return replace(self, parameters=parameters, known=None if self.structural else self.archive)

    @override
    def in_own_process(self, patience: float) -> Self:
        return replace(self, isolated=patience, in_process=False, known=self.archive)

    @override
    def in_this_process(self) -> Self:
        return replace(self, isolated=None, in_process=True, known=self.archive)

    @cached_property
    def is_own(self) -> bool:
        """Whether it was built here."""
        return is_own_build(Path(self.path), self.archive.files)

    @property
    def patience(self) -> float | None:
        """[s] The time that one call may take in a process of its own; `None` for an FMU that runs in this process."""
        if self.isolated is not None or self.in_process or self.is_own:
            return self.isolated
        return PATIENCE

    @override
    def acting_through_step(self, outputs: Collection[str]) -> Self:
        through_step = self.through_step.union(outputs)
        return (
            self if through_step == self.through_step else replace(self, through_step=through_step, known=self.archive)
        )

    @override
    def make_ready(self, progress: Progress) -> None:
        compile_beforehand(self.archive, progress)

    @override
    def describe(self) -> SourceDescription:
        version = Version(self.archive.version)
        requested = self.in_process or self.isolated is not None
        return SourceDescription(
            self.interface.kind, Path(self.path), version, self.patience, self.archive.chosen, requested
        )

    @override
    def open(self, name: str) -> Unit:
        if self.patience is None and self.is_own:
            return fmu_unit(name, sharing(self.archive))
        # Only FMUs of other makers need these.
        if self.patience is None:
            from fmus.units.guarded_unit import GuardedUnit  # noqa: PLC0415

            return GuardedUnit(name, self.archive)
        from fmus.units.isolated_unit import IsolatedUnit  # noqa: PLC0415

        return IsolatedUnit(name, self.archive, self.patience)

    @override
    def foreign_problem(self, unit: str) -> None:
        return None

    @override
    def single_instance(self) -> Path | None:
        return self.archive.path if self.patience is None and self.archive.only_once else None

    @override
    def element_names(self, variable: Variable, role: str) -> Sequence[str]:
        return self.archive.element_names(variable.name, _CAUSALITIES[role])

    @property
    @override
    def has_own_values(self) -> bool:
        return True

    @property
    @override
    def observable(self) -> Mapping[str, str]:
        return observable(self.archive)

    @override
    def observing(self, names: Sequence[str]) -> Self:
        return replace(self, known=observing(self.archive, names, self.parameters))

    @override
    def declares(self, name: str) -> bool:
        return self.archive.declares(name)

    @property
    @override
    def suggested(self) -> SuggestedExperiment:
        return self.archive.suggested

    @property
    @override
    def is_fmi2(self) -> bool:
        return self.archive.version is not Version.FMI3

    @property
    @override
    def structural(self) -> tuple[str, ...]:
        return self.archive.structural

    @property
    @override
    def references(self) -> Mapping[str, Sequence[int]]:
        return self.archive.references


@checked_arguments
def block_source(value: Block[Any, Any, Any]) -> InProcess:
    """Make the source of a unit from a block with its parameter values.

    Args:
        value: The block, such as `Bicycle(...)`.

    Returns:
        The source, for the units of a `System`; the block runs in this process.
    """
    return InProcess(type(value), {f.name: getattr(value, f.name) for f in dataclasses.fields(value)})  # type: ignore[arg-type]
