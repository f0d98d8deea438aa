"""How metrics are called in the report's tables, and in which order."""

from __future__ import annotations

from typing import Final

COLUMNS: Final = {
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

MORE: Final = {
    "distance": "largest distance [m]",
    "failures": "failed solves",
    "p50_us": "time per sample, p50 [us]",
    "share": "share in which it holds",
    "cases": "variations compared",
    "cannot be compared": "variations not comparable",
}


def title(name: str) -> str:
    """The title of a metric, `X of Y` included."""
    own, of, whose = name.partition(" of ")
    found = {**COLUMNS, **MORE}.get(own, own)
    return f"{found}, {whose}" if of else found


def number(value: float) -> str:
    """A value in three significant digits, whole numbers as they are."""
    if value == round(value) and abs(value) < 1e6:  # noqa: PLR2004 - longer ones are no counts
        return f"{value:.0f}"
    return f"{value:.3g}"
