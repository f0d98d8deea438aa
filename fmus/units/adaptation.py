"""How the variables of a foreign unit stand for the signals of a socket, as data that `mapped_unit` acts upon."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from components.interfaces.conversion import IDENTITY, Linear
from fmus.units.conventions import Convention

VariableElement: TypeAlias = tuple[str, int]
"""An element of a variable: the name of the variable, and the index of the element, from 0."""


@dataclass(frozen=True)
class Link:
    """One signal of ours and the elements of theirs that stand for its first elements: ``ours = relation(theirs)``."""

    signal: str
    """Name of our signal."""
    theirs: tuple[VariableElement, ...]
    """Their element for each element of our signal, in order."""
    relation: Linear = IDENTITY
    low: float = -math.inf
    high: float = math.inf
    """Limits of the values that theirs is given, in its own unit of measurement."""


@dataclass(frozen=True)
class RateInput:
    """An input of theirs that is the rate of a signal of ours.

    Over each step the rate leads from the present value to the signal's: ``(signal - present) / h``, within the limit.
    The present value is shown by the unit (`present`, an output of theirs) or computed by the adapter.
    """

    rate: Link
    present: Link | None
    limit: float = math.inf
    """The largest rate, in the signal's unit of measurement per second."""


@dataclass(frozen=True)
class Adaptation:
    """Everything between a foreign unit (theirs) and a socket (ours)."""

    inputs: tuple[Link, ...] = ()
    outputs: tuple[Link, ...] = ()
    constants: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Outputs of ours that have no variable of theirs, with their values."""
    held: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Inputs of theirs that no signal of ours drives, with their values."""
    conventions: Mapping[str, tuple[Convention, ...]] = field(default_factory=dict[str, tuple[Convention, ...]])
    """By bus, in the order in which they are applied to what the foreign unit shows."""
    rates: tuple[RateInput, ...] = ()
    integrated: tuple[str, ...] = ()
    """Outputs of ours of which the foreign unit shows the rate; they start at 0."""
    passed_on: tuple[str, ...] = ()
    """Outputs of theirs that are shown under their own names."""
