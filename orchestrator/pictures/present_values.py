"""The values at the time cursor: a short table for every row, which the viewer shows beside the plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from components.interfaces.maths import Array
from orchestrator.pictures import plots
from orchestrator.pictures.signals import Signal, SignalColumns
from orchestrator.system.system import System

_MOST = 12
"""The most values of the table: more have no room beside the plots."""


def shown_signals(system: System, signals: Sequence[Signal]) -> list[Signal]:
    """The signals of the plots of the first page, which the table has; scalars only."""
    answers = plots.questions(system, signals).values()
    found = {signal.path: signal for plots_of_one in answers for plot in plots_of_one for signal in plot.signals}
    return [signal for signal in found.values() if not signal.variable.shape][:_MOST]


def tables(columns: SignalColumns, signals: Sequence[Signal], derived: Mapping[str, Array]) -> list[str]:
    """A table in Markdown for each row.

    Args:
        columns: The rows.
        signals: The signals of the table, as far as the rows have them.
        derived: Other values [m] by name, `(n,)`; infinite or NaN where there is none.

    Returns:
        A text per row.
    """
    units = {s.path: "" if s.unit_of_measurement == "1" else s.unit_of_measurement for s in signals}
    values = [(s.name, units[s.path], columns.of(s.path)) for s in signals if columns.has(s.path)]
    values += [(name, "m", numbers) for name, numbers in derived.items()]
    cells = [[f"{name}|{_text(x, unit)}|" for x in numbers] for name, unit, numbers in values]
    times = [f"t|{t:.2f} s|" for t in columns.time]
    return [_table(row) for row in zip(times, *cells, strict=True)]


def _table(cells: Sequence[str]) -> str:
    """Cells of a name and a value, two in a line; the first line is the head, as an empty one would take its room."""
    head, *lines = (f"|{''.join(cells[i : i + 2])}" for i in range(0, len(cells), 2))
    return "\n".join([head, "|-|-|-|-|", *lines])


def _text(value: float, unit: str) -> str:
    return f"{round(value, 3):.3g} {unit}".rstrip() if np.isfinite(value) else "-"
