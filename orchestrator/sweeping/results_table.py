"""The table of a sweep: a row for each variant that is done."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.sampling import VARIANT
from orchestrator.sweeping.variation import typed
from orchestrator.sweeping.work import VariantResult

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
    done = [results[n] for n in numbers]
    columns: dict[str, Any] = {VARIANT: numbers}
    columns |= {path: [values[n] for n in numbers] for path, values in values_of(planned).items()}
    columns[STATUS] = [FINISHED if not r.fault else ENDED_BY for r in done]
    for name in _names(r.verdicts for r in done):
        columns[name] = pd.array([r.verdicts.get(name) for r in done], dtype="boolean")
    for name in _names(r.metrics for r in done):
        columns[name] = [r.metrics.get(name, float("nan")) for r in done]
    columns[ENDED_BY] = [r.fault for r in done]
    columns[CAUSE] = [r.cause for r in done]
    columns[SECONDS] = [r.seconds for r in done]
    return pd.DataFrame(columns)


def results_in(table: pd.DataFrame, paths: Iterable[str]) -> dict[int, VariantResult]:
    """The results that a table was made from, without the signals that were watched."""
    verdicts, metrics = verdict_names(table), metric_names(paths, table)
    found: dict[int, VariantResult] = {}
    for row in table.to_dict("records"):
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


def _names(entries: Any) -> list[str]:
    return list(dict.fromkeys(name for one in entries for name in one))
