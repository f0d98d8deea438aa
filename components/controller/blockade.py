"""What blocks the own lane, and where that asks for the changes out of it and back; the rules stand in `planner`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

from components.controller.lanes import Lanes, Way, in_lane
from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from components.interfaces.maths import both, cos, either, fmax, where

_FAR = 1e6
"""[m] Further away than anything that a decision depends on."""
_SLOWEST_CLOSING = 0.1
"""[m/s] An obstacle that the ego gains on more slowly than this does not block it."""


@dataclass(frozen=True)
class Blockade:
    """Whether the own lane is blocked, and where that asks for the changes."""

    blocked: bool
    x_1: float
    x_8: float
    stays: bool
    """Whether there is no room for a return before `x_8`."""
    corner: tuple[float, float]
    """Corner of the boundary of the obstacle that is passed first."""


def blockade(  # noqa: PLR0913 - the lanes, their traffic, and the manoeuvre
    lanes: Lanes,
    way: Way,
    ego: VehicleState,
    obstacles: ObstacleList,
    keep: bool,  # noqa: FBT001 - a condition of the equations
    soonest_return: float,
) -> Blockade:
    """What blocks the own lane; once the ego is out of it, only obstacles in the way of the return count.

    Args:
        lanes: The lanes.
        way: The way around the obstacles.
        ego: The vehicle of this instant.
        obstacles: The traffic of this instant.
        keep: Whether the ego is in its own lane.
        soonest_return: Where the return begins at the soonest once it is not [m].
    """
    longer = way.length - lanes.l_change  # what is in sight is the same by either way
    side = where(way.y < lanes.y_lane, -1.0, 1.0)
    reached: list[tuple[bool, float, float]] = []
    first, corner_x, corner_y = _FAR, _FAR, lanes.y_lane
    for i in range(SLOTS):
        closing = lanes.v_ref - obstacles.v[i] * cos(obstacles.psi[i])
        caught = both(closing > _SLOWEST_CLOSING, in_lane(lanes, obstacles.y[i], lanes.y_lane))
        stretch = lanes.v_ref / fmax(closing, _SLOWEST_CLOSING)
        x_1 = ego.x + stretch * (obstacles.x[i] - lanes.l_before - ego.x) - way.length
        x_8 = ego.x + stretch * (obstacles.x[i] + lanes.l_after - ego.x)
        ahead = both(x_8 > ego.x, x_1 + longer < ego.x + lanes.l_sight)
        blocks = both(obstacles.valid[i], both(caught, ahead))
        reached.append((blocks, x_1, x_8))
        nearer = both(blocks, x_1 < first)
        first = where(nearer, x_1, first)
        corner_x = where(nearer, obstacles.x[i] - obstacles.length[i] / 2 - lanes.l_gap, corner_x)
        corner_y = where(nearer, obstacles.y[i] + side * (obstacles.width[i] / 2 + lanes.l_gap), corner_y)

    x_task = lanes.x_task - lanes.l_before - way.length, lanes.x_task + lanes.l_after
    requested = both(x_task[1] > ego.x, x_task[0] + longer < ego.x + lanes.l_sight)
    reached.append((requested, *x_task))
    nearer = both(requested, x_task[0] < first)
    first = where(nearer, x_task[0], first)
    corner_x, corner_y = where(nearer, lanes.x_task, corner_x), where(nearer, lanes.y_lane, corner_y)

    blocked = reduce(either, (blocks for blocks, _, _ in reached))
    soonest = where(keep, first, soonest_return)
    back = soonest
    for _ in range(SLOTS):  # each round passes at least one more of the obstacles that leave no room for a return
        for blocks, x_1, x_8 in reached:
            back = where(both(blocks, x_1 < back + way.length), fmax(back, x_8), back)
    return Blockade(blocked=blocked, x_1=first, x_8=back, stays=back > soonest, corner=(corner_x, corner_y))
