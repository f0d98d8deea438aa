"""What is known of a unit before it runs: its inputs, outputs and parameters, and how it acts in time."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.record import Variable
from fmus.clock import Clock


@dataclass(frozen=True)
class SuggestedExperiment:
    """The experiment that the file of a unit suggests; times in [s]."""

    start: float = 0.0
    stop: float | None = None
    step: float | None = None
    """The communication step that the unit prefers."""
    fixed_step: float | None = None
    """The step in which the unit computes, whatever it is asked for."""
    any_step: bool = True
    """Whether the unit says that it takes steps of any length."""
    tolerance: float | None = None
    """The relative tolerance."""


def is_tunable(parameter: Variable) -> bool:
    """Whether a parameter of a block may be changed while it runs; what it starts from is used at the start only."""
    return not parameter.name.endswith("_start")


@dataclass(frozen=True)
class Interface:
    """What is known of a unit before it runs."""

    kind: str
    """The name of the block, or of the model in an FMU."""
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    feedthrough: NDArray[np.bool_]
    """Whether an input reaches an output without delay, variable by variable, of shape (outputs, inputs)."""
    output_after_set: bool
    """Whether outputs follow the inputs at one communication point; if not, they change with a step only."""
    starts: Mapping[str, Any]
    """The start values of the unit itself, by the name of a parameter or an input."""
    event_mode: bool = False
    """Whether the unit has the capability `events`: FMI 3.0 Event Mode."""
    rolls_back: bool = False
    """Whether the unit has the capability `state`: it returns to states that were saved."""
    clocks: tuple[Clock, ...] = ()
    """The clocks of FMI 3.0, in the order of the file."""
    aliases: Mapping[str, str] = field(default_factory=dict[str, str])
    """Aliases of inputs, outputs and parameters, each with the name of its variable."""
    initials: tuple[Variable, ...] = ()
    """Outputs and local variables whose start value may be set like that of a parameter."""
    variability: Mapping[str, str] = field(default_factory=dict[str, str])
    """FMI's variability of what may be given a value, such as `tunable`, by the name of the variable."""
    undeclared: frozenset[str] = frozenset()
    """Outputs whose dependencies the file does not declare; they are taken to depend on every input."""
    observed: tuple[Variable, ...] = ()
    """Local variables and parameters whose values are recorded with the outputs; nothing can be connected to them."""

    def variable(self, role: str, name: str) -> Variable:
        """A variable of a role (`inputs`, `outputs`, `parameters` or `initials`), which must be there."""
        return self._by_name[role][name]

    @cached_property
    def _by_name(self) -> dict[str, dict[str, Variable]]:
        roles = ("inputs", "outputs", "parameters", "initials")
        return {role: {v.name: v for v in getattr(self, role)} for role in roles}

    def acting_through_step(self, outputs: Collection[str]) -> Interface:
        """The same, where inputs reach some of the outputs through a step only, whatever the file says of them."""
        through = self.feedthrough.copy()
        through[[i for i, v in enumerate(self.outputs) if v.name in outputs]] = False
        return replace(self, feedthrough=through, undeclared=self.undeclared - {*outputs})

    @property
    def tunable(self) -> frozenset[str]:
        """The parameters whose values may be changed while the unit runs."""
        return frozenset(v.name for v in self.parameters if self.variability.get(v.name) == "tunable")

    @property
    def discrete(self) -> frozenset[str]:
        """The inputs that change at instants only, although they may be floating-point numbers."""
        return frozenset(v.name for v in self.inputs if self.variability.get(v.name) == "discrete")

    @property
    def recorded(self) -> tuple[Variable, ...]:
        """All variables that the unit shows: its outputs, then what is observed besides."""
        return (*self.outputs, *self.observed)
