"""Smoothness at matched accuracy: what a two-level tracker would give at the path error of another controller.

The gains of a tracker trace a curve of smoothness over path error. At the other controller's path error the curve is
interpolated between neighbouring gains; where it reaches that path error more than once, its smoothest value counts,
so that each tracker is compared at its best. Nothing is extrapolated beyond the ends of the curve.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from orchestrator.reproduction.paper.evidence import Curve, Result

ACCURACY: Final = "path_error_rms"
SMOOTHNESS: Final = ("r_total_variation", "r_dot_rms")


@dataclass(frozen=True)
class Comparison:
    """Whether a run is smoother than a curve at the same accuracy."""

    smoother: bool | None
    """None where the curve does not decide it."""
    at: Mapping[str, float]
    """The metrics of the curve at that accuracy, or at its nearest end."""
    runs: tuple[str, ...]
    """The points of the curve that these metrics come from."""
    how: str


def compare(metrics: Mapping[str, float], curve: Curve) -> Comparison:
    """Compare the metrics of a run with the curve of a tracker.

    Args:
        metrics: The metrics of the run, `ACCURACY` and `SMOOTHNESS` among them.
        curve: The results of the tracker with several gains.
    """
    points = [p for p in curve.points if p.finished]
    if not points:
        return Comparison(None, {}, (), "no gain leads to the end of the run")
    error = metrics[ACCURACY]
    best, worst = (choose(points, key=_error) for choose in (min, max))
    if error < _error(best):
        smoother = _smoother(metrics, best.metrics) or None
        return Comparison(smoother, _of(best), (best.name,), "no gain is that accurate; its most accurate one")
    if error > _error(worst):
        smoother = None if _smoother(metrics, worst.metrics) else False
        return Comparison(smoother, _of(worst), (worst.name,), "every gain is more accurate; its least accurate one")
    least = {name: _least(points, name, error) for name in SMOOTHNESS}
    interpolated = {name: value for name, (value, _) in least.items()}
    runs = tuple(dict.fromkeys(run for _, names in least.values() for run in names))
    return Comparison(_smoother(metrics, interpolated), interpolated, runs, "interpolated between gains")


def _error(point: Result) -> float:
    return point.metrics[ACCURACY]


def _smoother(a: Mapping[str, float], b: Mapping[str, float]) -> bool:
    return all(a[name] < b[name] for name in SMOOTHNESS)


def _of(point: Result) -> dict[str, float]:
    return {name: point.metrics[name] for name in (ACCURACY, *SMOOTHNESS)}


def _least(points: Sequence[Result], name: str, error: float) -> tuple[float, tuple[str, ...]]:
    """The least value of the curve at a path error inside its range, and the points that it lies between."""
    values: list[tuple[float, tuple[str, ...]]] = [(p.metrics[name], (p.name,)) for p in points if _error(p) == error]
    for first, second in pairwise(points):
        a, b = _error(first), _error(second)
        if min(a, b) < error < max(a, b):
            share = (error - a) / (b - a)
            value = first.metrics[name] + (second.metrics[name] - first.metrics[name]) * share
            values.append((value, (first.name, second.name)))
    return min(values)
