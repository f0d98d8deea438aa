"""Inputs that follow a table, as series: no unit shows them, so that they are in no row that is recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from components.interfaces.maths import Array
from orchestrator.pictures import palette
from orchestrator.pictures.shapes import SeriesStyle, SeriesValues
from orchestrator.system.input_table import InputColumn
from orchestrator.system.system import System


def driven(system: System) -> Sequence[InputColumn]:
    """The columns of a system's table that are numbers."""
    return [] if system.table is None else [column for column in system.table.columns if column.type.is_number]


def driven_styles(system: System, at: Callable[..., str]) -> Iterator[SeriesStyle]:
    """The name and the colour of each.

    Args:
        system: The system.
        at: Gives the path of an entity, from its first part and the others.
    """
    for i, column in enumerate(driven(system)):
        held = column.hold or not column.type.is_float
        colour = palette.SERIES[i % len(palette.SERIES)]
        entity = at("signals", *column.path.split("."))
        yield SeriesStyle(entity=entity, names=[column.path], colours=[colour], held=held)


def driven_values(system: System, at: Callable[..., str], times: Array) -> Iterator[SeriesValues]:
    """The values of each at some times [s], `(n,)`."""
    for column in driven(system):
        if system.table is not None:
            values = np.asarray(column.at(system.table.times, times), dtype=float)
            yield SeriesValues(entity=at("signals", *column.path.split(".")), values=values)
