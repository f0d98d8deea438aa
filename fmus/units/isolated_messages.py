"""The exchange between `IsolatedUnit` and the process of its FMU: calls, replies, and columns in shared memory.

Numbers lie in a file that both processes map; texts and bytes, which have no fixed size, go with the messages.
"""

from __future__ import annotations

import mmap
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from components.interfaces.problem import Problem
from components.interfaces.quantity import DTYPES, Type, zeros
from fmus.reading.archive import InterfaceType
from fmus.unit_interface import Interface
from fmus.units.unit import Column, TypedColumns, widths

_ALIGNMENT: Final = 8


@dataclass(frozen=True)
class Instantiation:
    """The first request: make the unit."""

    name: str
    path: Path
    parameters: Mapping[str, Any]
    lenient: bool
    interface_type: InterfaceType
    memory: Path
    """The file that both processes map."""
    observed: tuple[str, ...] = ()
    """The variables that are recorded besides the outputs."""


@dataclass(frozen=True)
class UnitCall:
    """A request for one call of a method of the unit, or of one of its capabilities."""

    method: str
    arguments: tuple[Any, ...] = ()
    set_first: bool = False
    """Whether the inputs have changed and have to be set before."""
    get_after: bool = False
    """Whether the outputs are wanted afterwards."""
    texts: list[list[Any]] = field(default_factory=list[list[Any]])
    """The inputs that are texts or bytes, type by type."""


@dataclass(frozen=True)
class UnitReply:
    """The reply to a request."""

    value: Any = None
    messages: tuple[str, ...] = ()
    texts: list[list[Any]] = field(default_factory=list[list[Any]])
    """The outputs that are texts or bytes, type by type."""
    problems: tuple[Problem, ...] = ()
    """The problems of a `RequestError`."""
    remarks: tuple[str, ...] = ()
    end: float | None = None
    """[s] The time at which the unit asks for the end of the run."""
    fault: tuple[str, tuple[str, ...]] | None = None
    """The `action` and `said` of a `UnitError`."""


def map_columns(interface: Interface, file: Path) -> tuple[dict[Type, Column], dict[Type, Column]]:
    """The columns of all inputs and of all recorded variables of a unit, whose numbers lie in a file.

    Args:
        interface: The interface of the unit, the same in both processes.
        file: The shared file; it is made by the process that comes first.
    """
    roles = widths(interface.inputs), widths(interface.recorded)
    size = _ALIGNMENT + sum(_bytes(kind, n) for role in roles for kind, n in role.items() if kind.is_number)
    with file.open("a+b") as opened:
        opened.truncate(size)
        memory = mmap.mmap(opened.fileno(), size)
    columns: list[dict[Type, Column]] = []
    at = 0
    for role in roles:
        columns.append({})
        for kind, n in role.items():
            if kind.is_number:
                columns[-1][kind] = np.frombuffer(memory, DTYPES[kind], n, at)
                at += _bytes(kind, n)
            else:
                columns[-1][kind] = zeros(kind, n)
    return columns[0], columns[1]


def texts(columns: TypedColumns) -> list[list[Any]]:
    """The values of columns that are no numbers."""
    return [column.tolist() for kind, column in columns.items() if not kind.is_number]


def put_texts(columns: TypedColumns, values: list[list[Any]]) -> None:
    """Write the values that `texts` gave; an empty list, where they were not requested, changes nothing."""
    for column, items in zip([c for kind, c in columns.items() if not kind.is_number], values, strict=False):
        column[:] = items


def _bytes(kind: Type, n: int) -> int:
    return -(-n * np.dtype(DTYPES[kind]).itemsize // _ALIGNMENT) * _ALIGNMENT
