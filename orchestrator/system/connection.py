"""Connections: each leads from an output signal, or one element of an array, to an input signal or element."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from components.interfaces.conversion import IDENTITY, Transformation
from components.interfaces.record import Variable


@dataclass(frozen=True)
class ArrayElement:
    """One element of an array: its name (`x[2]`) and its index among all elements, counted from 0."""

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
    """The conversion from the output's unit of measurement to the input's, then any transformation of the system."""
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
    """Whether a path names a signal or one of its elements.

    Args:
        path: The path in question, such as `x[2]`.
        whole: The path of the signal, such as `x`.
    """
    return path == whole or (path.startswith(f"{whole}[") and path.endswith("]"))


def signal(name: str, variables: Sequence[Variable]) -> tuple[Variable, ArrayElement | None] | None:
    """Find the variable that a name refers to.

    Args:
        name: The name of a variable, or of one element of an array, such as `x[2]`.
        variables: The variables to search.

    Returns:
        The variable, and the element that the name refers to; `None` in its place for the whole variable, and `None`
        for a name that no variable has.
    """
    for variable in variables:
        if variable.name == name:
            return variable, None
        if variable.shape and is_part(name, variable.name) and name in (elements := variable.elements):
            return variable, ArrayElement(name, elements.index(name))
    return None
