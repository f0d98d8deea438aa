"""What comes of fitting an FMU to a socket: what stands for each signal, what was noticed, and what is wrong."""

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
    """One signal of the socket, and what stands for it."""

    signal: Variable
    direction: Direction
    needed: bool
    """Whether the FMU cannot fill the socket without it."""
    theirs: str = ""
    """Variables and constants as text; empty where there is nothing."""
    note: str = ""
    """What was decided without being told, as text."""
    doubtful: tuple[str, ...] = ()
    """Variables whose names are equally good, so that none of them is taken."""
    misfit: bool = False
    """Whether there is a variable of this name that cannot stand for the signal; a problem says why."""


@dataclass(frozen=True)
class Remark:
    """Something that was decided or noticed without being asked about."""

    text: str
    signal: str = ""
    """The signal whose variable was decided on, as its `FittedSignal` says too; empty for all else."""


@dataclass(frozen=True)
class Fitting:
    """An FMU in a socket: all that was decided, and what is wrong."""

    mapping: MappingFile
    """Complete: with an entry for every signal that something stands for."""
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
        """What was noticed, as texts."""
        return tuple(remark.text for remark in self.noticed)
