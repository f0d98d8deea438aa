"""An FMU file that has been read, with the content of its description."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from fmus.reading.declared_variables import whole_name
from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.binaries import MachineCode
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface, SuggestedExperiment

VALID_FMU: Final = (
    f"an FMU: a zip archive with {MODEL_DESCRIPTION}, FMI 1.0, 2.0 or 3.0, for Co-Simulation or Model Exchange"
)
"""The valid files, as the part of a message."""
INTERFACE_TYPES: Final = ("CoSimulation", "ModelExchange")
"""FMI's names of the interface types; where an FMU has both, the first is used."""


@dataclass(frozen=True)
class Archive:
    """An FMU file that has been read, and that can be used."""

    path: Path
    version: Version
    description: Any
    """The model description as FMPy reads it."""
    interface: Interface
    references: dict[str, list[int]]
    """Value references of each variable: one per element in FMI 2.0, one in all in FMI 3.0."""
    structural: tuple[str, ...] = ()
    """Structural parameters: those that the lengths of arrays depend on."""
    clocks_of: Mapping[str, frozenset[int]] = field(default_factory=dict[str, frozenset[int]])
    """Value references of the clocks of each clocked variable."""
    remarks: tuple[str, ...] = ()
    """Remarks for the user: the rules of FMI that it breaks, and its requirements."""
    files: frozenset[str] = frozenset()
    """The paths of all files in it."""
    root: Any = None
    """The root element of its model description."""
    negated: frozenset[str] = frozenset()
    """Variables of FMI 1.0 whose values are the negative ones of those of the library."""
    library: str | None = None
    """The path of the library for this platform in it; None where it has none, so that its sources are compiled."""
    code: MachineCode = field(default_factory=MachineCode)
    """What that library says of itself."""

    @property
    def is_model_exchange(self) -> bool:
        """Whether the importer has to integrate it, because it has no solver of its own."""
        return self.description.coSimulation is None

    @property
    def interface_types(self) -> tuple[str, ...]:
        """The interface types that it offers, as FMI names them: `CoSimulation`, `ModelExchange`, or both."""
        elements = (self.description.coSimulation, self.description.modelExchange)
        return tuple(name for name, element in zip(INTERFACE_TYPES, elements, strict=True) if element is not None)

    @property
    def title(self) -> str:
        """What it says that it is: its description, or the name of its model."""
        return str(self.description.description or self.description.modelName)

    @property
    def suggested(self) -> SuggestedExperiment:
        """The experiment that it suggests."""
        default, interface = self.description.defaultExperiment, self.interface_type
        return SuggestedExperiment(
            start=_number(getattr(default, "startTime", None)) or 0.0,
            stop=_number(getattr(default, "stopTime", None)),
            step=_number(getattr(default, "stepSize", None)),
            fixed_step=_number(getattr(interface, "fixedInternalStepSize", None)),
            any_step=self.is_model_exchange or bool(interface.canHandleVariableCommunicationStepSize),
            tolerance=_number(getattr(default, "tolerance", None)),
        )

    def declares(self, name: str) -> bool:
        """Whether it declares a variable of a name, also one that no master exchanges."""
        return any(v.name == name for v in self.description.modelVariables)

    def element_names(self, name: str, causalities: Collection[str]) -> list[str]:
        """The names of the elements of an array that FMI 2.0 spreads over scalar variables, as the file spells them.

        Args:
            name: The name of the array.
            causalities: FMI's causalities of its elements; another variable may have the same value reference.

        Returns:
            The names in the order of the elements.
        """
        spelled = {
            v.valueReference: str(v.name)
            for v in self.description.modelVariables
            if v.causality in causalities and whole_name(v.name, {name: None}) == name
        }
        return [spelled[reference] for reference in self.references[name]]

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


def _number(value: Any) -> float | None:
    return None if value is None or value == "" else float(value)
