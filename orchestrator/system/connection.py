"""Connections: each leads from an output signal, or one element of an array, to an input signal or element."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter

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


class SignalNames:
    """The names of variables and of the elements of their arrays; each is found at once, however many there are.

    Args:
        variables: The variables, such as all inputs of a unit.
    """

    def __init__(self, variables: Iterable[Variable]) -> None:
        self.variables = {variable.name: variable for variable in variables}
        self._elements: dict[str, dict[str, ArrayElement]] = {}

    def find(self, name: str) -> tuple[Variable, ArrayElement | None] | None:
        """Find the variable that a name refers to.

        Args:
            name: The name of a variable, or of one element of an array, such as `x[2]`.

        Returns:
            The variable, and the element that the name refers to; `None` in its place for the whole variable, and
            `None` for a name that no variable has.
        """
        if (variable := self.variables.get(name)) is not None:
            return variable, None
        variable = self.variables.get(name.rpartition("[")[0])
        element = self._elements_of(variable).get(name) if variable is not None and variable.shape else None
        return None if variable is None or element is None else (variable, element)

    def _elements_of(self, array: Variable) -> dict[str, ArrayElement]:
        if array.name not in self._elements:
            self._elements[array.name] = {name: ArrayElement(name, at) for at, name in enumerate(array.elements)}
        return self._elements[array.name]

    def in_bus(self, bus: str) -> list[str]:
        """The names of the variables in a bus, in their order."""
        found = self._sorted[bisect_left(self._sorted, (f"{bus}.",)) : bisect_left(self._sorted, (f"{bus}/",))]
        return [name for name, _ in sorted(found, key=itemgetter(1))]  # `/` comes after `.`

    @cached_property
    def _sorted(self) -> list[tuple[str, int]]:
        """All names with their places, so that those of a bus lie side by side."""
        return sorted((name, at) for at, name in enumerate(self.variables))
