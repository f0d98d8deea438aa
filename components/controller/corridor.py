"""The corridor: what the road's edges and the obstacles' boundaries leave free at a station of the road.

An obstacle pushes in the edge of its own side by its box and the safety gap `l_gap`; the push fades
over ramps of length `l_ramp` before and behind the box (RESOLUTIONS 16). Obstacles move on at their present speed.
"""

from __future__ import annotations

from components.interfaces.buses import SLOTS, ObstacleList
from components.interfaces.maths import absolute, both, clip, cos, fmax, fmin, negate, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record


@record
class Road:
    """Edges of the road and the shape of an obstacle's boundary."""

    y_left: float = quantity("m", "left edge of the road")
    y_right: float = quantity("m", "right edge of the road")
    l_gap: float = quantity("m", "safety gap around an obstacle", min=0)
    l_ramp: float = quantity("m", "length of the corridor's ramp before and behind an obstacle", min=0.1)


def corridor(
    road: Road, obstacles: ObstacleList, x: float, t: float, y_parting: float | None = None
) -> tuple[float, float]:
    """What is free across the road.

    Args:
        road: Edges of the road, and the shape of an obstacle's boundary.
        obstacles: The obstacles of this instant.
        x: Station along the road [m].
        t: Time from now [s].
        y_parting: An obstacle left of it pushes in the left edge, any other the right one [m]; the middle of the road
            if not given.

    Returns:
        Upper (left) and lower (right) boundary [m].
    """
    middle = (road.y_left + road.y_right) / 2 if y_parting is None else y_parting
    upper, lower = road.y_left, road.y_right
    for i in range(SLOTS):
        ahead = obstacles.x[i] + obstacles.v[i] * cos(obstacles.psi[i]) * t
        beyond = absolute(x - ahead) - obstacles.length[i] / 2 - road.l_gap
        share = clip(1 - beyond / road.l_ramp, 0.0, 1.0)
        half = obstacles.width[i] / 2 + road.l_gap
        on_left = obstacles.y[i] > middle
        push_left = fmax(road.y_left - (obstacles.y[i] - half), 0.0) * share
        push_right = fmax(obstacles.y[i] + half - road.y_right, 0.0) * share
        here = obstacles.valid[i]
        upper = where(both(here, on_left), fmin(upper, road.y_left - push_left), upper)
        lower = where(both(here, negate(on_left)), fmax(lower, road.y_right + push_right), lower)
    return upper, lower
