"""The result of fitting an FMU to a socket: the variables for each signal, remarks, and problems."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from components.interfaces.problem import Problem
from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from fmus.units.adaptation import Adaptation
from orchestrator.mapping.mapping_file import MappingFile

Direction: TypeAlias = Literal["inputs", "outputs"]
"""Whether a unit reads a signal or shows it; named as the lists of `Interface` and `Socket.signals` are."""


@dataclass(frozen=True)
class FittedSignal:
    """One signal of the socket, and the variables or constants that stand for it."""

    signal: Variable
    direction: Direction
    needed: bool
    """Whether the FMU cannot fill the socket without it."""
    theirs: str = ""
    """Variables and constants as text; empty where there is nothing."""
    note: str = ""
    """A decision that no mapping file gave, as text."""
    doubtful: tuple[str, ...] = ()
    """Variables whose names are equally good, so that none of them is taken."""
    misfit: bool = False
    """Whether there is a variable of this name that cannot stand for the signal; a problem says why."""


@dataclass(frozen=True)
class Remark:
    """A decision that no mapping file gave, or an observation."""

    text: str
    signal: str = ""
    """The signal whose variable was decided on, as its `FittedSignal` says too; empty for all else."""


@dataclass(frozen=True)
class Fitting:
    """An FMU in a socket: all decisions, and all problems."""

    mapping: MappingFile
    """The complete mapping, with an entry for every signal that something stands for."""
    adaptation: Adaptation
    interface: Interface
    rows: tuple[FittedSignal, ...]
    problems: tuple[Problem, ...]
    noticed: tuple[Remark, ...]
    needed: bool
    """Whether there is anything to translate at all."""
    plain: bool
    """Whether values pass as they are, under the same names."""

    @property
    def remarks(self) -> tuple[str, ...]:
        """All decisions and observations, as texts."""
        return tuple(remark.text for remark in self.noticed)
