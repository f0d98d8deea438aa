"""Connections: one signal, or one element of an array, into another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from components.interfaces.conversion import IDENTITY, Transformation
from components.interfaces.record import Variable


@dataclass(frozen=True)
class ArrayElement:
    """One element of an array: its name (`x[2]`) and its place among all elements, from 0."""

    name: str
    at: int


@dataclass(frozen=True)
class Connection:
    """One input signal and the output signal that drives it, or one element of either."""

    unit: str
    input: str
    source: str
    output: str
    conversion: Transformation = IDENTITY
    """From the output's unit to the input's, and what the system asks for beyond that."""
    input_element: ArrayElement | None = None
    output_element: ArrayElement | None = None

    @property
    def target(self) -> str:
        """The full path of the input, or of its element."""
        return f"{self.unit}.{self.input_element.name if self.input_element else self.input}"

    @property
    def origin(self) -> str:
        """The full path of the output, or of its element."""
        return f"{self.source}.{self.output_element.name if self.output_element else self.output}"

    def __str__(self) -> str:
        return f"{self.origin} -> {self.target}"


def is_part(path: str, whole: str) -> bool:
    """Whether a path is that of a signal, or of one of its elements."""
    return path == whole or (path.startswith(f"{whole}[") and path.endswith("]"))


def signal(name: str, variables: Sequence[Variable]) -> tuple[Variable, ArrayElement | None] | None:
    """The variable of a name, or the one that has an element of this name."""
    for variable in variables:
        if variable.name == name:
            return variable, None
        if variable.shape and is_part(name, variable.name) and name in (elements := variable.elements):
            return variable, ArrayElement(name, elements.index(name))
    return None
