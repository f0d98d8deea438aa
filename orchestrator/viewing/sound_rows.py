"""Rows of unknown state, as far as they can be what a run has written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from components.interfaces.problem import listed, refuse
from orchestrator.pictures.signals import Signal, signals
from orchestrator.results.run_folder import KeptRun

_NUMBERS: Final = "fiub"
"""The kinds of arrays of numbers, as numpy names them."""


def sound_rows(run: KeptRun, columns: Mapping[str, Any], where: str, tell: Callable[[str], None]) -> Mapping[str, Any]:
    """The columns of a table that the signals of a run may have.

    Args:
        run: The run.
        columns: The values of each column, `(n,)`.
        where: The file that they are from.
        tell: Called with a line that names what is left out.

    Returns:
        The times, and all columns with values of the type of their signal.

    Raises:
        RequestError: The times are none that the run can have.
    """
    _check_times(run, columns.get("time"), where)
    known = {column: signal for signal in signals(run.scenario.system) for column in signal.columns}
    wrong = [name for name, values in columns.items() if name in known and not _fits(known[name], values)]
    if wrong:
        tell(f"{where}: {listed(wrong)}: values of another type; left out")
    return {name: values for name, values in columns.items() if name not in wrong}


def _check_times(run: KeptRun, times: Any, where: str) -> None:
    valid, remedy = "the rows of this run", "Run it again."
    if times is None or times.dtype.kind not in _NUMBERS:
        raise refuse(where, "no column `time` with numbers", valid, remedy)
    seconds, grid = times.astype(float), run.scenario.grid
    last = grid.until + grid.h
    if not (np.isfinite(seconds).all() and (np.diff(seconds) > 0).all()):
        raise refuse(where, "times that do not increase", valid, remedy)
    if len(seconds) and not (seconds[0] >= grid.start - grid.h and seconds[-1] <= last):
        found = f"times from {seconds[0]:g} s to {seconds[-1]:g} s"
        raise refuse(where, found, f"times from {grid.start:g} s to {grid.until:g} s", remedy)


def _fits(signal: Signal, values: Any) -> bool:
    if signal.is_number:
        return values.dtype.kind in _NUMBERS
    return all(isinstance(value, str if signal.is_text else bytes) for value in values.tolist())
