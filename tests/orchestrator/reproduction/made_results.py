"""Results with metrics that no run has to give: what verdicts are tested with."""

from __future__ import annotations

from orchestrator.reproduction.paper.evidence import Curve, Result
from orchestrator.reproduction.paper.experiments import RunRole

SMOOTH = {
    "gap_obstacle": 1.5,
    "gap_edge": 0.2,
    "corridor_violations": 0.0,
    "path_error_rms": 0.2,
    "path_error_max": 0.5,
    "r_peak": 0.6,
    "r_rms": 0.3,
    "r_total_variation": 5.0,
    "r_sign_changes": 5.0,
    "r_dot_rms": 0.6,
    "r_dot_peak": 1.6,
    "delta_f_rate_rms": 0.2,
    "v_x_min": 9.8,
    "solver_limits": 0.0,
    "solver_fallbacks": 0.0,
}
ROUGH = {
    **SMOOTH,
    "r_peak": 1.2,
    "r_rms": 0.5,
    "r_total_variation": 12.0,
    "r_sign_changes": 8.0,
    "r_dot_rms": 2.0,
    "r_dot_peak": 8.0,
    "delta_f_rate_rms": 1.2,
}


def result(role, metrics, label, task="static", controller="", plant="bicycle", **more):
    name = f"{task}-{plant}-{label}"
    return Result(name, task, plant, controller or label, role, label, {**metrics, **more})


def mp(metrics=SMOOTH, **more):
    return result(RunRole.MP, metrics, "MP tuned", controller="mpc", **more)


def lqr(metrics=ROUGH, **more):
    return result(RunRole.TWO_LEVEL, metrics, "LQR", controller="lqr", **more)


def curve(*points, plant="bicycle"):
    """A sweep with these path errors, total variations of r and rms r_dot."""
    made = [
        Result(f"sweep-{i}", "static", plant, "lqr", RunRole.SWEEP, "LQR", dict(zip(
            ("path_error_rms", "r_total_variation", "r_dot_rms"), point, strict=True)))
        for i, point in enumerate(points)
    ]  # fmt: skip
    return Curve("sweep", "static", plant, "LQR", tuple(made))
