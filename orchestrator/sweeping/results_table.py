"""The table of a sweep: a row for each variant that is done."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from orchestrator.sweeping.journal import VariantResult, VariantResults
from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.sampling import VARIANT
from orchestrator.sweeping.variation import typed

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

STATUS: Final = "status"
ENDED_BY: Final = "fault"
CAUSE: Final = "cause"
SECONDS: Final = "seconds"
FINISHED: Final = "finished"
"""The columns beside values, metrics and verdicts; and the status of a variant that came to its stop time."""


def values_of(planned: PlannedSweep) -> dict[str, list[Any]]:
    """The values of all variants, by path, as numbers where they are numbers."""
    return {path: typed(values, planned.quantities[path]) for path, values in planned.columns.items()}


def results_table(planned: PlannedSweep, results: Mapping[int, VariantResult]) -> pd.DataFrame:
    """A row for each variant that is done: its values, metrics, verdicts, fault and time."""
    import pandas as pd  # noqa: PLC0415 - slow to import, and most of macrostep does without

    numbers = sorted(results)
    columns: dict[str, Any] = {VARIANT: numbers}
    columns |= {path: [values[n] for n in numbers] for path, values in values_of(planned).items()}
    verdicts: dict[str, list[Any]] = {}
    metrics: dict[str, list[Any]] = {}
    told: dict[str, list[Any]] = {STATUS: [], ENDED_BY: [], CAUSE: [], SECONDS: []}
    for row, n in enumerate(numbers):  # one at a time, because there may be very many
        result = results[n]
        _add(verdicts, row, result.verdicts, None)
        _add(metrics, row, result.metrics, float("nan"))
        status = ENDED_BY if result.fault else FINISHED
        _add(told, row, {STATUS: status, ENDED_BY: result.fault, CAUSE: result.cause, SECONDS: result.seconds}, None)
    columns[STATUS] = told.pop(STATUS)
    columns |= {name: pd.array(values, dtype="boolean") for name, values in verdicts.items()}
    return pd.DataFrame({**columns, **metrics, **told})


def results_in(table: pd.DataFrame, paths: Iterable[str]) -> VariantResults:
    """The results that a table was made from, without the signals that were watched."""
    verdicts, metrics = verdict_names(table), metric_names(paths, table)
    found, names = VariantResults(), [str(name) for name in table.columns]
    for values in table.itertuples(index=False, name=None):  # one at a time, because there may be very many
        row = dict(zip(names, values, strict=True))
        number = int(row[VARIANT])
        measured = {name: float(row[name]) for name in metrics if np.isfinite(row[name])}
        kept = {name: bool(row[name]) for name in verdicts if isinstance(row[name], bool | np.bool_)}
        found[number] = VariantResult(number, float(row[SECONDS]), measured, kept, str(row[ENDED_BY]), str(row[CAUSE]))
    return found


def verdict_names(table: pd.DataFrame) -> list[str]:
    """The verdicts of a table of results."""
    return [str(name) for name in table.columns if str(table[name].dtype) == "boolean"]


def metric_names(paths: Iterable[str], table: pd.DataFrame) -> list[str]:
    """The metrics of a table of results."""
    others = {VARIANT, STATUS, ENDED_BY, CAUSE, SECONDS, *paths, *verdict_names(table)}
    return [str(name) for name in table.columns if name not in others]


def _add(columns: dict[str, list[Any]], row: int, values: Mapping[str, Any], absent: Any) -> None:
    """Add a row to columns, of which some may be new."""
    for name in values:
        if name not in columns:
            columns[name] = [absent] * row
    for name, column in columns.items():
        column.append(values.get(name, absent))
