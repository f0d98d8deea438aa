"""What a sweep shows: shares of the verdicts, distributions, the worst variants, causes of failures, Sobol indices."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from orchestrator.results.provenance import SHOWN_METRICS
from orchestrator.scenario.options import Options
from orchestrator.sweeping.bands import PERCENTILES
from orchestrator.sweeping.plan import PlannedSweep
from orchestrator.sweeping.ranking import worst_first
from orchestrator.sweeping.results_table import (
    CAUSE,
    ENDED_BY,
    FINISHED,
    STATUS,
    metric_names,
    results_in,
    verdict_names,
)
from orchestrator.sweeping.sampling import VARIANT

if TYPE_CHECKING:  # slow to import, and only the name is needed
    import pandas as pd

WORST_SHOWN: Final = 10
_CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Share:
    """How often something holds."""

    name: str
    holds: int
    known: int
    low: float
    high: float
    """The ends of the 95 % confidence interval (Wilson) of the share."""

    @property
    def value(self) -> float:
        """The share."""
        return self.holds / self.known


@dataclass(frozen=True)
class Group:
    """Variants that failed alike."""

    cause: str
    variants: tuple[int, ...]


def shown_metrics(paths: Iterable[str], table: pd.DataFrame) -> dict[str, str]:
    """The metrics that are drawn, with their units of measurement; all of them for what is no vehicle on a road."""
    known = metric_names(paths, table)
    return {n: u for n, u in SHOWN_METRICS.items() if n in known and table[n].notna().any()}


def shares(table: pd.DataFrame) -> list[Share]:
    """How many variants ended, and how many keep each verdict."""
    found = [_share("finished", table[STATUS] == FINISHED)]
    return found + [_share(name.replace("_", " "), table[name].dropna().astype(bool)) for name in verdict_names(table)]


def _share(name: str, holds: pd.Series[Any]) -> Share:
    from scipy.stats import binomtest  # noqa: PLC0415 - slow to import

    count, known = int(holds.sum()), len(holds)
    if not known:
        return Share(name, 0, 0, 0.0, 1.0)
    interval = binomtest(count, known).proportion_ci(_CONFIDENCE, "wilson")
    return Share(name, count, known, float(interval.low), float(interval.high))


def spreads(paths: Iterable[str], table: pd.DataFrame) -> dict[str, list[float]]:
    """The least value, percentiles 5, 50 and 95, and the largest value of each metric."""
    found: dict[str, list[float]] = {}
    for name in metric_names(paths, table):
        values = table[name].to_numpy(dtype=float)
        values = values[np.isfinite(values)]
        if len(values):
            found[name] = [float(value) for value in np.percentile(values, list(PERCENTILES.values()))]
    return found


def ranked(paths: Iterable[str], table: pd.DataFrame) -> pd.DataFrame:
    """The variants, the worst first, as `ranking` has it."""
    return table.set_index(VARIANT, drop=False).loc[worst_first(results_in(table, paths))]


def groups(table: pd.DataFrame) -> list[Group]:
    """Variants that failed, by cause: the fault, or the verdicts that do not hold; the most frequent first."""
    by_cause: dict[str, list[int]] = {}
    verdicts = verdict_names(table)
    for _, alike in table.groupby([CAUSE, *verdicts], dropna=False, sort=False):
        if cause := cause_of({str(name): value for name, value in alike.iloc[0].items()}, verdicts):
            by_cause.setdefault(cause, []).extend(map(int, alike[VARIANT]))
    for variants in by_cause.values():
        variants.sort()
    return sorted((Group(c, tuple(v)) for c, v in by_cause.items()), key=lambda group: -len(group.variants))


def cause_of(row: Mapping[str, Any], verdicts: Sequence[str]) -> str:
    """Why a variant fails: its fault without the time, or the verdicts that do not hold; empty where it does not."""
    failed = [name.replace("_", " ") for name in verdicts if row[name] is False or row[name] is np.False_]
    return str(row[CAUSE]) or (f"not: {', '.join(failed)}" if failed else "")


def why(row: Mapping[str, Any], verdicts: Sequence[str]) -> str:
    """Why a variant fails: its fault, with the time, or the verdicts that do not hold; empty where it does not."""
    return str(row[ENDED_BY]) or cause_of(row, verdicts)


def sobol_table(planned: PlannedSweep, table: pd.DataFrame) -> dict[str, dict[str, tuple[float, float]]]:
    """First and total Sobol indices of the metrics, by metric and path; empty where the sampling does not allow it.

    They need the sampling `saltelli:N`, and a metric that every variant has.
    """
    if planned.sampling.kind != "saltelli" or len(table) != len(planned):
        return {}
    from scipy.stats import sobol_indices  # noqa: PLC0415

    n, paths = planned.sampling.count, list(planned.columns)
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for name in metric_names(paths, table):
        values = table[name].to_numpy(dtype=float)
        if not np.isfinite(values).all() or np.ptp(values) == 0:
            continue
        parts = values.reshape(len(paths) + 2, n)
        func: Any = {"f_A": parts[0][None], "f_B": parts[1][None], "f_AB": parts[2:][:, None]}
        indices = sobol_indices(func=func, n=n)
        first, total = np.ravel(indices.first_order), np.ravel(indices.total_order)
        found[name] = {p: (float(a), float(b)) for p, a, b in zip(paths, first, total, strict=True)}
    return found


def command(planned: PlannedSweep, number: int) -> str:
    """The command that runs a variant on its own."""
    return command_of(planned.request.scenario, planned.options_of(planned.variant(number)))


def command_of(scenario: str, options: Options) -> str:
    """The command that runs a scenario with some options."""
    words = ["macrostep", "run", scenario]
    plain = Options()
    if options.mode != plain.mode:
        words += ["--blocks"] if options.mode == "blocks" else ["--fmi", str(int(options.mode))]
    for socket, unit in options.replacements.items():
        words += [f"--{socket}", str(unit)]
    for name in ("step", "stop_time", "start_time", "tolerance", "algorithm", "input"):
        if (value := getattr(options, name)) is not None:
            words += [f"--{name.replace('_', '-')}", str(value)]
    flags = ("solve_loops", "end_off_road", "lenient", "input_hold", "in_process")
    words += [f"--{name.replace('_', '-')}" for name in flags if getattr(options, name) is True]
    for option, values in _repeated(options).items():
        words += [word for value in values for word in (option, value)]
    return shlex.join(words)


def _repeated(options: Options) -> Mapping[str, Sequence[str]]:
    return {
        "--allow-nonfinite": options.allow_nonfinite,
        "--isolate": options.isolate,
        "--interface": options.interface,
        "--set": options.settings,
    }
