"""A block's variables as FMI sees them: causality, variability, start value and value reference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from components.interfaces.block import Block
from components.interfaces.maths import Array
from components.interfaces.quantity import Type
from components.interfaces.record import Variable

Causality: TypeAlias = Literal["parameter", "input", "output"]
Variability: TypeAlias = Literal["fixed", "tunable", "discrete", "continuous"]

TIME_REFERENCE = 0
"""The value reference of the independent variable of FMI 3.0."""


@dataclass(frozen=True)
class FmiVariable:
    """One variable of an FMU; an array is one variable here, whatever the version of FMI."""

    variable: Variable
    causality: Causality
    variability: Variability
    reference: int
    """Value reference of the first element; the others follow."""
    start: tuple[float, ...]
    """Start values of parameters and inputs, element by element; empty for outputs."""

    @property
    def name(self) -> str:
        """The dotted name."""
        return self.variable.name

    @property
    def references(self) -> range:
        """The value references of all elements."""
        return range(self.reference, self.reference + self.variable.size)


@dataclass(frozen=True)
class Interface:
    """All variables of a block's FMU: parameters, inputs and outputs, in the order of their value references."""

    block: type[Block[Any, Any, Any]]
    sampled: bool
    parameters: tuple[FmiVariable, ...]
    inputs: tuple[FmiVariable, ...]
    outputs: tuple[FmiVariable, ...]

    def __iter__(self) -> Iterator[FmiVariable]:
        yield from self.parameters
        yield from self.inputs
        yield from self.outputs


def interface_of(block: type[Block[Any, Any, Any]], *, sampled: bool, start: Array) -> Interface:
    """The variables of a block whose parameters start at `start`, one column in the order of `block.parameters()`."""
    parameters = _placed(block.parameters(), "parameter", TIME_REFERENCE + 1, sampled, start)
    zero = [first for v in block.inputs() for first in [_first_value(v)] * v.size]
    inputs = _placed(block.inputs(), "input", _end(parameters, TIME_REFERENCE + 1), sampled, zero)
    outputs = _placed(block.outputs(), "output", _end(inputs, _end(parameters, TIME_REFERENCE + 1)), sampled, ())
    return Interface(block, sampled, parameters, inputs, outputs)


def _placed(
    variables: Sequence[Variable],
    causality: Causality,
    first: int,
    sampled: bool,  # noqa: FBT001 - private
    start: Array | Sequence[float],
) -> tuple[FmiVariable, ...]:
    made: list[FmiVariable] = []
    at = 0
    for v in variables:
        values = tuple(float(value) for value in start[at : at + v.size])
        made.append(FmiVariable(v, causality, _variability(v, causality, sampled), first + at, values))
        at += v.size
    return tuple(made)


def _end(placed: Sequence[FmiVariable], otherwise: int) -> int:
    return placed[-1].references.stop if placed else otherwise


def _variability(v: Variable, causality: Causality, sampled: bool) -> Variability:  # noqa: FBT001 - private
    if causality == "parameter":
        return "fixed" if v.name.endswith("_start") else "tunable"
    if v.quantity.type is not Type.FLOAT64 or (sampled and causality == "output"):
        return "discrete"
    return "continuous"


def _first_value(v: Variable) -> float:
    items = v.quantity.enumeration
    return 0.0 if items is None else float(next(iter(items)).value)
