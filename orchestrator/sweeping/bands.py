"""What chosen signals have in common over all variants: at each time their mean, and the range in which they lie."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from orchestrator.scenario.table_file import TIME
from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.watched_signals import values

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

SIGNAL: Final = "signal"
UNIT: Final = "unit"
TICK: Final = "tick"
VARIANTS: Final = "variants"
MEAN: Final = "mean"
PERCENTILES: Final = {"least": 0, "5 %": 5, "median": 50, "95 %": 95, "largest": 100}
BAND_COLUMNS: Final = (SIGNAL, UNIT, TICK, TIME, VARIANTS, MEAN, *PERCENTILES)
"""The columns of a table of bands; those beside the mean are percentiles of the variants that lasted so long."""


def band_table(planned: PlannedSweep, signals: Mapping[int, Mapping[str, bytes]]) -> pd.DataFrame:
    """The signals that are watched, over time.

    Args:
        planned: The sweep.
        signals: What is kept of them, by the number of the variant.

    Returns:
        A row for each signal and tick: the time [s], the number of variants that had a value then, their mean and
        percentiles.
    """
    import pandas as pd  # noqa: PLC0415 - slow to import, and most of macrostep does without

    tables: list[pd.DataFrame] = []
    for name, unit in planned.watched.columns.items():
        kept = [signals[n][name] for n in sorted(signals) if name in signals[n]]
        if kept:
            columns = {
                SIGNAL: name,
                UNIT: unit,
                TICK: 0,
                TIME: planned.scenario.start,
                **_statistics([values(one) for one in kept]),
            }
            table = pd.DataFrame(columns)
            table[TICK] += np.arange(len(table)) * planned.watched.every_row
            table[TIME] += table[TICK] * planned.scenario.h
            tables.append(table[table[VARIANTS] > 0])
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=list(BAND_COLUMNS))


def _statistics(kept: list[NDArray[np.float64]]) -> dict[str, Any]:
    """Statistics at each row of runs of different lengths, whose values need not be finite."""
    rows = max(map(len, kept))
    table = np.full((len(kept), rows), np.nan)
    for row, one in zip(table, kept, strict=True):
        row[: len(one)] = np.where(np.isfinite(one), one, np.nan)
    known = np.isfinite(table).sum(axis=0)
    some = known > 0
    found = {VARIANTS: known, **{name: np.full(rows, np.nan) for name in (MEAN, *PERCENTILES)}}
    if some.any():
        found[MEAN][some] = np.nanmean(table[:, some], axis=0)
        for name, values_ in zip(
            PERCENTILES, np.nanpercentile(table[:, some], list(PERCENTILES.values()), axis=0), strict=True
        ):
            found[name][some] = values_
    return found
