"""A block's variables as FMI sees them: causality, variability, start value and value reference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from components.interfaces.block import Block
from components.interfaces.maths import Array
from components.interfaces.quantity import Type
from components.interfaces.record import Variable

Causality: TypeAlias = Literal["parameter", "input", "output"]
Variability: TypeAlias = Literal["fixed", "tunable", "discrete", "continuous"]

TIME_REFERENCE: Final = 0
"""The value reference of the independent variable of FMI 3.0."""

COMMUNICATION_STEP: Final = 0.1
"""Step size [s] that the default experiment suggests, and interval of a sampled block's clock unless another is set."""


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
class Clock:
    """The periodic input clock of a sampled block (FMI 3.0): it acts at each tick, the first of which is at the start.

    It has the name of the function it triggers, which no parameter can have.
    """

    reference: int
    name: str = "sample"
    description: str = "the block acts at each tick; in event mode only"
    interval: float = COMMUNICATION_STEP
    """Time [s] from one tick to the next, which the importer may change in Initialization Mode."""


@dataclass(frozen=True)
class Interface:
    """All variables of a block's FMU: parameters, inputs and outputs, in the order of their value references."""

    block: type[Block[Any, Any, Any]]
    sampled: bool
    parameters: tuple[FmiVariable, ...]
    inputs: tuple[FmiVariable, ...]
    outputs: tuple[FmiVariable, ...]
    clock: Clock | None
    """The clock of a sampled block; it is not among the variables, which both versions of FMI have."""

    def __iter__(self) -> Iterator[FmiVariable]:
        yield from self.parameters
        yield from self.inputs
        yield from self.outputs


def interface_of(block: type[Block[Any, Any, Any]], *, sampled: bool, start: Array) -> Interface:
    """The variables of a block whose parameters start at `start`, one column in the order of `block.parameters()`."""
    parameters = _placed(block.parameters(), "parameter", TIME_REFERENCE + 1, sampled, start)
    zero = [first for v in block.inputs() for first in [_first_value(v)] * v.size]
    inputs = _placed(block.inputs(), "input", _after(parameters), sampled, zero)
    outputs = _placed(block.outputs(), "output", _after(parameters, inputs), sampled, ())
    clock = Clock(_after(parameters, inputs, outputs)) if sampled else None
    return Interface(block, sampled, parameters, inputs, outputs, clock)


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


def _after(*placed: Sequence[FmiVariable]) -> int:
    """The value reference after all of these."""
    return TIME_REFERENCE + 1 + sum(v.variable.size for group in placed for v in group)


def _variability(v: Variable, causality: Causality, sampled: bool) -> Variability:  # noqa: FBT001 - private
    if causality == "parameter":
        return "fixed" if v.name.endswith("_start") else "tunable"
    if v.quantity.type is not Type.FLOAT64 or (sampled and causality == "output"):
        return "discrete"
    return "continuous"


def _first_value(v: Variable) -> float:
    items = v.quantity.enumeration
    return 0.0 if items is None else float(next(iter(items)).value)
