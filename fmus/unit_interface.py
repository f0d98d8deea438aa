"""What can be seen of a unit before it runs: its inputs, outputs and parameters, and how it acts in time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.interfaces.record import Variable
from fmus.clock import Clock


@dataclass(frozen=True)
class Interface:
    """What can be seen of a unit before it runs."""

    kind: str
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    parameters: tuple[Variable, ...]
    feedthrough: NDArray[np.bool_]
    """(outputs, inputs), variable by variable: whether an input reaches an output without delay"""
    output_after_set: bool
    """Whether outputs follow the inputs at one communication point, before the step; if not, they show by stepping."""
    starts: Mapping[str, Any]
    """Start values that the unit brings along, by parameter or input."""
    event_mode: bool = False
    """Whether the unit can be activated at an instant: FMI 3.0 Event Mode"""
    rolls_back: bool = False
    """Whether `save` and `restore` work"""
    clocks: tuple[Clock, ...] = ()
    aliases: Mapping[str, str] = field(default_factory=dict[str, str])
    """Other names of inputs, outputs and parameters, each with the name it stands for"""
    initials: tuple[Variable, ...] = ()
    """Outputs and local variables whose start value may be set like that of a parameter"""
    undeclared: frozenset[str] = frozenset()
    """Outputs whose dependencies the file does not declare; they are taken to depend on every input"""
