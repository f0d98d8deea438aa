"""What the sources of units have in common, whether blocks or files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self

from components.interfaces.problem import Problem
from components.interfaces.progress import Progress
from components.interfaces.record import Variable
from fmus.unit_interface import Interface, SuggestedExperiment
from fmus.units.unit import Unit
from orchestrator.system.source_description import SourceDescription


class UnitSource(ABC):
    """What a unit of a system is made from, with the parameter values that it is given.

    Sources are immutable: methods that change one return another. The final classes are `InProcess` (a block), `Fmu`,
    and `orchestrator.mapping.mapped.Mapped` (an FMU behind the interface of a socket).
    """

    MADE_BY: ClassVar = "Make one of a file with Fmu(path), of a block with block_source(block)."
    """What to do where something else is given."""
    parameters: Mapping[str, Any]
    """Values by name; parameters with a start value in the interface need an entry only where theirs differs."""

    @property
    @abstractmethod
    def interface(self) -> Interface:
        """The inputs, outputs and parameters of the unit. Raises `RequestError`."""

    @abstractmethod
    def with_parameters(self, parameters: Mapping[str, Any]) -> Self:
        """The same source with other parameter values."""

    @abstractmethod
    def describe(self) -> SourceDescription:
        """Describe what the unit is made from and how it runs. Raises `RequestError`."""

    @abstractmethod
    def open(self, name: str) -> Unit:
        """Open the unit, which messages call `name`. Raises `RequestError` and `UnitError`."""

    @abstractmethod
    def foreign_problem(self, unit: str) -> Problem | None:
        """The problem that keeps other tools from running the unit; `None` where they can."""

    def make_ready(self, progress: Progress) -> None:  # noqa: B027 - only files have something to do
        """Do what takes long before any unit is opened, and tell it before: compile sources. Raises `RequestError`."""

    def for_other_tools(self) -> UnitSource:
        """The source that is exported to other tools: this one, or an equivalent one that needs no mapping."""
        return self

    @property
    def through_step(self) -> frozenset[str]:
        """The outputs of its file that inputs reach through a step only, though the file may not say so."""
        return frozenset()

    def acting_through_step(self, outputs: Collection[str]) -> UnitSource:  # noqa: ARG002 - a file may need it
        """The same source, where inputs reach some of the outputs through a step only, whatever its file says."""
        return self

    def in_own_process(self, patience: float) -> UnitSource | None:  # noqa: ARG002 - a file can, others cannot
        """The same source in a process of its own, whose calls may take `patience` seconds; `None` where it cannot."""
        return None

    def in_this_process(self) -> UnitSource:
        """The same source in this process, whoever has built it."""
        return self

    def mapping_text(self, file: str | None = None) -> str | None:  # noqa: ARG002 - a mapped FMU has one
        """The mapping to a socket as TOML, for an FMU called `file`; `None` where there is none."""
        return None

    def single_instance(self) -> Path | None:
        """The file that can be instantiated only once per process; `None` where several instances are possible."""
        return None

    @property
    def has_own_values(self) -> bool:
        """Whether its parameters have values in it that nobody has to give, also where its file does not tell them."""
        return False

    @property
    def free_inputs(self) -> Sequence[Variable]:
        """The inputs of its file that are none of the unit, because nothing of the unit's socket drives them."""
        return ()

    def holding(self, inputs: Mapping[str, Any]) -> UnitSource:  # noqa: ARG002 - a mapped FMU may have some
        """The same source, in which some of its `free_inputs` hold other values. Raises `RequestError`."""
        return self

    def element_names(self, variable: Variable, role: str) -> Sequence[str]:
        """The names of the elements of an array as its file spells them.

        Args:
            variable: The array.
            role: The list of the interface that it stands in: `inputs`, `outputs`, `parameters` or `initials`.
        """
        del role
        return variable.elements

    @property
    def observable(self) -> Mapping[str, str]:
        """The names of the variables that can be recorded besides the outputs, each with its causality in FMI."""
        return {}

    def observing(self, names: Sequence[str]) -> UnitSource:  # noqa: ARG002 - there are none
        """The same source, whose units show these `observable` variables, too. Raises `RequestError`."""
        return self

    def declares(self, name: str) -> bool:  # noqa: ARG002 - a file may, others do not
        """Whether the file declares a variable of a name, even one that no master exchanges."""
        return False

    @property
    def suggested(self) -> SuggestedExperiment:
        """The experiment that the file suggests; a block suggests nothing."""
        return SuggestedExperiment()

    @property
    def is_fmi2(self) -> bool:
        """Whether it is an FMU of FMI 2.0, or 1.0, as its file has it, whose arrays are scalar variables."""
        return False

    @property
    def structural(self) -> tuple[str, ...]:
        """The parameters that lengths of arrays depend on."""
        return ()

    @property
    def references(self) -> Mapping[str, Sequence[int]]:
        """The value references of each variable; empty for a source that is not an FMU."""
        return {}
