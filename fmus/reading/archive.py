"""An FMU file that has been read, with the content of its description."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import refuse
from fmus.reading.joined_arrays import array_name
from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.binaries import MachineCode
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface, SuggestedExperiment

VALID_FMU: Final = (
    f"an FMU: a zip archive with {MODEL_DESCRIPTION}, FMI 1.0, 2.0 or 3.0, for Co-Simulation or Model Exchange"
)
"""The valid files, as the part of a message."""


class InterfaceType(StrEnum):
    """The interface types, by FMI's names; where an FMU has both and nobody chooses, the first is used."""

    CO_SIMULATION = "CoSimulation"
    MODEL_EXCHANGE = "ModelExchange"

    @property
    def in_words(self) -> str:
        """The name as people write it."""
        return "Co-Simulation" if self is InterfaceType.CO_SIMULATION else "Model Exchange"

    @property
    def short(self) -> str:
        """The name as people type it: `cs` or `me`."""
        return "".join(letter.lower() for letter in self if letter.isupper())


def interface_type_named(text: str, where: str) -> InterfaceType:
    """The interface type that a text means: `cs`, `me`, or the name in any spelling.

    Args:
        text: The text.
        where: Where it stands, for messages.

    Raises:
        RequestError: It means none.
    """
    plain = re.sub(r"[\W_]", "", text).lower()
    for kind in InterfaceType:
        if plain in (kind.short, kind.lower()):
            return kind
    raise refuse(where, f"`{text}`", " or ".join(f"{kind.short} ({kind})" for kind in InterfaceType))


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
    breaks_rules: bool = False
    """Whether its description breaks rules of FMI, which the remarks tell."""
    files: frozenset[str] = frozenset()
    """The paths of all files in it."""
    root: Any = None
    """The root element of its model description."""
    negated: frozenset[str] = frozenset()
    """Variables of FMI 1.0 whose values are the negative ones of those of the library."""
    library: str | None = None
    """The path of the library for this platform in it; None where it has none, so that its sources are compiled."""
    library_digest: str = ""
    """The SHA-256 of that library."""
    code: MachineCode = field(default_factory=MachineCode)
    """What that library says of itself."""
    chosen: InterfaceType = InterfaceType.CO_SIMULATION
    """The interface type that is used."""
    unpacked: Path | None = None
    """Where its files lie already; without it each unit unpacks them, and has the library for itself."""
    shares_files: bool = False
    """Whether units take the files from the user's cache instead, so that several have the same library."""
    where: str = ""
    """How messages name it: its path, or its place in the SSP that it was taken from."""

    @property
    def is_model_exchange(self) -> bool:
        """Whether the importer has to integrate it, because it has no solver of its own."""
        return self.chosen is InterfaceType.MODEL_EXCHANGE

    @property
    def interface_types(self) -> tuple[InterfaceType, ...]:
        """The interface types that it offers."""
        return interface_types(self.description)

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
        elements = self._elements.get(name, ())
        if self.version is Version.FMI3 or not elements:  # an array of FMI 3.0 is one variable
            return [name]
        spelled = {reference: element for element, reference, causality in elements if causality in causalities}
        return [spelled[reference] for reference in self.references[name]]

    @cached_property
    def _elements(self) -> dict[str, list[tuple[str, int, str]]]:
        """The variables that would be elements of an array, by its name: their names, references and causalities."""
        found: dict[str, list[tuple[str, int, str]]] = {}
        for v in self.description.modelVariables:
            if (array := array_name(v.name)) is not None:
                found.setdefault(array, []).append((str(v.name), v.valueReference, v.causality or "local"))
        return found

    @property
    def is_plain_fmi3(self) -> bool:
        """Whether it is FMI 3.0 Co-Simulation, which can be stepped without Event Mode."""
        return self.version == Version.FMI3 and not self.is_model_exchange

    @property
    def interface_type(self) -> Any:
        """The element of the interface type that is used, with its capabilities."""
        return self.description.modelExchange if self.is_model_exchange else self.description.coSimulation

    @property
    def only_once(self) -> bool:
        """Whether a process can hold only one instance of it."""
        return bool(self.interface_type.canBeInstantiatedOnlyOncePerProcess)


def interface_types(description: Any) -> tuple[InterfaceType, ...]:
    """The interface types that a model description offers.

    Args:
        description: The model description as FMPy reads it.
    """
    elements = (description.coSimulation, description.modelExchange)
    return tuple(kind for kind, element in zip(InterfaceType, elements, strict=True) if element is not None)


def _number(value: Any) -> float | None:
    if value is None or value == "":
        return None
    if not isfinite(number := float(value)):
        raise ValueError(f"`{value}`, which is no finite number")
    return number
