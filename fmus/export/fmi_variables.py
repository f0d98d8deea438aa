"""A block's variables as FMI sees them: causality, variability, start value and value reference."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from components.interfaces.block import Block
from components.interfaces.maths import Array
from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.unit_interface import is_tunable

Causality: TypeAlias = Literal["parameter", "input", "output"]
Variability: TypeAlias = Literal["fixed", "tunable", "discrete", "continuous"]

TIME_REFERENCE: Final = 0
"""The value reference of the independent variable of FMI 3.0."""

COMMUNICATION_STEP: Final = 0.1
"""[s] The step size of the default experiment, and the interval of a sampled block's clock unless another is set."""


@dataclass(frozen=True)
class FmiVariable:
    """One variable of an FMU; an array is one variable here in both versions of FMI."""

    variable: Variable
    causality: Causality
    variability: Variability
    reference: int
    """Value reference of the first element; those of the other elements follow."""
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
class SampleClock:
    """The periodic input clock of a sampled block (FMI 3.0): the block acts at each tick, first at the start time.

    The clock has the name of the block's method that it triggers, so that no parameter can have it.
    """

    reference: int
    name: str = "sample"
    description: str = "the block acts at each tick; in event mode only"
    interval: float = COMMUNICATION_STEP
    """[s] The time from one tick to the next, which the importer may change in Initialization Mode."""


@dataclass(frozen=True)
class FmiVariables:
    """All variables of a block's FMU: parameters, inputs and outputs, in the order of their value references."""

    block: type[Block[Any, Any, Any]]
    sampled: bool
    parameters: tuple[FmiVariable, ...]
    inputs: tuple[FmiVariable, ...]
    outputs: tuple[FmiVariable, ...]
    clock: SampleClock | None
    """The clock of a sampled block, which only FMI 3.0 has; iteration leaves it out."""

    def __iter__(self) -> Iterator[FmiVariable]:
        yield from self.parameters
        yield from self.inputs
        yield from self.outputs


def fmi_variables_of(block: type[Block[Any, Any, Any]], *, sampled: bool, start: Array) -> FmiVariables:
    """The variables of a block's FMU.

    Args:
        block: The block.
        sampled: Whether it acts at ticks of a clock.
        start: Start values of the parameters, one column in the order of `block.parameters()`.
    """
    parameters = _placed(block.parameters(), "parameter", TIME_REFERENCE + 1, sampled, start)
    zero = [first for v in block.inputs() for first in [_first_value(v)] * v.size]
    inputs = _placed(block.inputs(), "input", _after(parameters), sampled, zero)
    outputs = _placed(block.outputs(), "output", _after(parameters, inputs), sampled, ())
    clock = SampleClock(_after(parameters, inputs, outputs)) if sampled else None
    return FmiVariables(block, sampled, parameters, inputs, outputs, clock)


def _placed(
    variables: Sequence[Variable],
    causality: Causality,
    first: int,
    sampled: bool,  # noqa: FBT001 - private
    start: Array | Sequence[float],
) -> tuple[FmiVariable, ...]:
    placed: list[FmiVariable] = []
    at = 0
    for v in variables:
        values = tuple(float(value) for value in start[at : at + v.size])
        placed.append(FmiVariable(v, causality, _variability(v, causality, sampled), first + at, values))
        at += v.size
    return tuple(placed)


def _after(*placed: Sequence[FmiVariable]) -> int:
    """The first value reference after those of some variables."""
    return TIME_REFERENCE + 1 + sum(v.variable.size for group in placed for v in group)


def _variability(v: Variable, causality: Causality, sampled: bool) -> Variability:  # noqa: FBT001 - private
    if causality == "parameter":
        return "tunable" if is_tunable(v) else "fixed"
    if v.quantity.type is not Type.FLOAT64 or (sampled and causality == "output"):
        return "discrete"
    return "continuous"


def _first_value(v: Variable) -> float:
    items = v.quantity.enumeration
    return 0.0 if items is None else float(next(iter(items)).value)
