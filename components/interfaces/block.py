"""Blocks: components written once, as a frozen description; the values live in the run that uses them."""

from __future__ import annotations

import dataclasses
import re
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, TypeVar, dataclass_transform, get_args, get_type_hints

import numpy as np

from components.interfaces.arguments import names_told
from components.interfaces.maths import is_symbolic
from components.interfaces.problem import raise_if_any, refuse
from components.interfaces.quantity import Quantity, boolean, enumeration, integer, quantity
from components.interfaces.record import Variable, record, value_problems, variables
from components.interfaces.runge_kutta import runge_kutta
from components.interfaces.socket import Socket

U = TypeVar("U")
X = TypeVar("X")
Y = TypeVar("Y")
B = TypeVar("B", bound="type[Block[Any, Any, Any]]")


@record
class NoState:
    """The state of a block without memory."""


class Block(ABC, Generic[U, X, Y]):
    """A component with inputs `U`, state `X` and outputs `Y`; its fields are its parameters.

    At each communication point the outputs are `output(x, u)`; the state then advances by `step(x, u, h)` with the
    inputs held. Both are pure, and are written for numbers and symbols alike.

    Raises:
        RequestError: At construction, with every name of a parameter that is unknown or missing, or else with every
            value that does not fit its quantity.
    """

    name: ClassVar[str]
    """The class's name in lower case with underscores, unless the class itself gives another."""
    summary: ClassVar[str]
    """The first line of the class's docstring, without its full stop."""
    socket: ClassVar[Socket]
    input_type: ClassVar[type]
    state_type: ClassVar[type]
    output_type: ClassVar[type]
    max_step: ClassVar[float] = float("inf")
    """Longest step [s] that `step` is called with; a longer macro step is divided evenly."""
    native: ClassVar[bool] = True
    """Whether the equations become C; blocks that call a library do not, and run in this process only."""
    staged: ClassVar[bool] = False
    """Whether parts of the equations become functions of their own in the generated C (see `staging`)."""
    if_longer: ClassVar[str] = ""
    """What a person can do whose list is longer than a parameter of this block: a sentence for messages."""
    definition: ClassVar[str] = ""
    """Digest of the file that the block was made from, if it was made from one."""

    def __post_init__(self) -> None:
        raise_if_any(value_problems(self, self.name, self.parameters()))
        for variable in self.parameters():
            value = getattr(self, variable.name)
            if variable.shape and not is_symbolic(value):
                object.__setattr__(self, variable.name, np.array(value, dtype=float))  # a list is accepted as an array

    @abstractmethod
    def start(self) -> X:
        """The state at the start of a run."""

    @abstractmethod
    def output(self, x: X, u: U) -> Y:
        """The outputs at a communication point.

        Args:
            x: The state at this instant.
            u: The inputs at this instant.
        """

    @abstractmethod
    def step(self, x: X, u: U, h: float) -> X:
        """The state after a step, with the inputs held.

        Args:
            x: The state at the beginning of the step.
            u: The inputs during the step.
            h: The length of the step [s], at most `max_step`.
        """

    @classmethod
    def dimensions(cls) -> dict[str, int]:
        """The structural constants that give array lengths: whole numbers in upper-case class attributes."""
        return {n: v for n in dir(cls) if n[0].isupper() and isinstance(v := getattr(cls, n), int)}

    @classmethod
    def parameters(cls) -> tuple[Variable, ...]:
        """The parameters, in order."""
        declared = variables(cls, cls.dimensions())
        return tuple(replace(v, quantity=replace(v.quantity, if_longer=cls.if_longer)) for v in declared)

    @classmethod
    def inputs(cls) -> tuple[Variable, ...]:
        """The input signals, in order."""
        return variables(cls.input_type, cls.dimensions())

    @classmethod
    def outputs(cls) -> tuple[Variable, ...]:
        """The output signals, in order."""
        return variables(cls.output_type, cls.dimensions())

    @classmethod
    def states(cls) -> tuple[Variable, ...]:
        """The state variables, in order."""
        return variables(cls.state_type, cls.dimensions())


class Continuous(Block[U, X, Y]):
    """A block given by differential equations, integrated by the classical Runge-Kutta method of order 4."""

    max_step = 0.01

    @abstractmethod
    def derivative(self, x: X, u: U) -> X:
        """The time derivative of the state, dx/dt.

        Args:
            x: The state.
            u: The inputs.

        Returns:
            A record of the type of the state, whose values are rates per second.
        """

    def step(self, x: X, u: U, h: float) -> X:
        """One Runge-Kutta step with the inputs held."""
        return runge_kutta(lambda state: self.derivative(state, u), x, h)


class Sampled(Block[U, X, Y]):
    """A block that acts once per communication point, with direct feedthrough; its outputs hold until the next."""

    @abstractmethod
    def sample(self, x: X, u: U) -> tuple[X, Y]:
        """The next state and the outputs of this sample.

        Args:
            x: The state that the previous sample gave.
            u: The inputs at this instant.
        """

    def output(self, x: X, u: U) -> Y:
        """The outputs of a sample taken now."""
        return self.sample(x, u)[1]

    def step(self, x: X, u: U, h: float) -> X:  # noqa: ARG002 - a sample does not depend on the step
        """The state after a sample taken now."""
        return self.sample(x, u)[0]


@dataclass_transform(
    frozen_default=True, kw_only_default=True, field_specifiers=(quantity, integer, boolean, enumeration)
)
def block(socket: Socket) -> Callable[[B], B]:
    """Make a class a block; its declarations are checked here, the values of its parameters at construction.

    Args:
        socket: The socket that the block has to fit.

    Returns:
        The decorator of the class.

    Raises:
        RequestError: A parameter has no quantity, or the buses do not fit the socket.
    """

    def declare(cls: B) -> B:
        decorated: Any = names_told(dataclass(frozen=True, kw_only=True, eq=False)(cls))
        decorated.name = vars(cls).get("name") or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()
        decorated.summary = (cls.__doc__ or "").strip().split("\n")[0].rstrip(".")
        decorated.socket = socket
        decorated.input_type, decorated.state_type, decorated.output_type = _signature(cls)
        for item in dataclasses.fields(decorated):
            if not isinstance(item.metadata.get("quantity"), Quantity):
                raise refuse(
                    f"{cls.__name__}.{item.name}", "a parameter without a quantity", "quantity(unit, description)"
                )
        raise_if_any(socket.problems(decorated.name, decorated.inputs(), decorated.outputs()))
        return decorated

    return declare


def _signature(cls: type) -> tuple[type, type, type]:
    for base in getattr(cls, "__orig_bases__", ()):
        arguments = get_args(base)
        if len(arguments) == 3 and not any(isinstance(part, TypeVar) for part in arguments):  # noqa: PLR2004
            for part in arguments:
                get_type_hints(part)
            return arguments
    raise refuse(cls.__name__, "no types for inputs, state and outputs", "class X(Continuous[Inputs, State, Outputs])")
