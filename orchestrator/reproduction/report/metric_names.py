"""The titles of metrics in the report's tables, their order, and how values and verdicts are written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

from orchestrator.reproduction.paper.verdict import DecidingNumber

METRIC_TITLES: Final = {
    "gap_obstacle": "gap to obstacle [m]",
    "gap_edge": "gap to edge [m]",
    "corridor_violations": "corridor violations",
    "path_error_rms": "path error, rms [m]",
    "path_error_max": "path error, max [m]",
    "r_peak": "peak r [rad/s]",
    "r_rms": "rms r [rad/s]",
    "r_total_variation": "TV(r) [rad/s]",
    "r_sign_changes": "sign changes of r",
    "r_dot_rms": "rms r_dot [rad/s2]",
    "r_dot_peak": "peak r_dot [rad/s2]",
    "delta_f_rate_rms": "rms steering rate [rad/s]",
    "a_y_peak": "peak a_y [m/s2]",
    "mu_f_max": "friction share, front",
    "mu_r_max": "friction share, rear",
    "v_x_min": "least v_x [m/s]",
    "v_x_max": "largest v_x [m/s]",
    "solver_limits": "solves at the limit",
    "solver_fallbacks": "solves that failed",
    "solver_iterations_max": "most iterations",
    "solver_kkt_max": "largest KKT residual",
}
"""Metrics of a run; those of a run folder that are not listed here follow under their own names."""

_DECIDING_TITLES: Final = METRIC_TITLES | {
    "distance": "largest distance [m]",
    "failures": "failed solves",
    "p50_us": "time per sample, p50 [us]",
    "share": "share in which it holds",
    "cases": "variations compared",
    "cannot be compared": "variations not comparable",
}
"""In addition to the metrics of a run, those that occur only in the cases of verdicts."""

_TABLES: Final = (
    ("Safety and accuracy", ("gap_obstacle", "gap_edge", "corridor_violations", "path_error_rms", "path_error_max")),
    (
        "Smoothness",
        (
            "r_peak",
            "r_rms",
            "r_total_variation",
            "r_sign_changes",
            "r_dot_rms",
            "r_dot_peak",
            "delta_f_rate_rms",
            "a_y_peak",
        ),
    ),
    ("Limits and speed", ("mu_f_max", "mu_r_max", "v_x_min", "v_x_max")),
    ("Solver", ("solver_iterations_max", "solver_kkt_max", "solver_limits", "solver_fallbacks")),
)
"""The table of metrics in parts that fit a page; together they have all `METRIC_TITLES`."""


def metric_tables(runs: Iterable[Mapping[str, Any]]) -> list[tuple[str, list[str]]]:
    """The tables of metrics that these runs need: heading, and the metrics that at least one run has."""
    present = dict.fromkeys(name for run in runs for name in run["metrics"])
    listed = {name for _, names in _TABLES for name in names}
    others = tuple(name for name in present if name not in listed)
    tables = [(heading, [n for n in names if n in present]) for heading, names in (*_TABLES, ("Others", others))]
    return [(heading, names) for heading, names in tables if names]


def metric_title(name: str) -> str:
    """The title of a metric of a run."""
    return METRIC_TITLES.get(name, name)


def deciding_title(name: str) -> str:
    """The title of a metric that decides a case."""
    return _DECIDING_TITLES.get(name, name)


def labelled(number: DecidingNumber) -> str:
    """A number of a case with its title."""
    of = f", {number.of}" if number.of else ""
    return f"{deciding_title(number.metric)}{of}: {written(number.value)}"


def written(value: float) -> str:
    """A value in three significant digits; whole numbers are written as they are."""
    if value == round(value) and abs(value) < 1e6:  # noqa: PLR2004 - longer ones are no counts
        return f"{value:.0f}"
    return f"{value:.3g}"


def sentence(text: str) -> str:
    """A phrase as a sentence."""
    return f"{text[:1].upper()}{text[1:]}."


def percentage(share: float) -> str:
    """A share as a percentage."""
    return f"{share:.1%}"
