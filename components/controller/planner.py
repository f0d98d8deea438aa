"""When to change lanes: where the path's waypoints lie, decided anew at every sample from the traffic of the moment.

Every obstacle in the ego's own lane that the ego would catch up with at `v_ref` blocks it. With closing speed c, the
ego is `l_before` behind it after travelling ``v_ref (x_o - l_before - x) / c`` and `l_after` ahead of it after
``v_ref (x_o + l_after - x) / c``: the change out is complete at the first, the return begins at the second. Obstacles
too close behind each other for a return between them are passed in one go. A change that has begun is kept until its
arc ends (RESOLUTIONS 22); one that has not begun is dropped when nothing asks for it any more. A change that is needed
at once begins at the ego. Nothing here checks that the adjacent lane is free.
"""

from __future__ import annotations

from dataclasses import dataclass

from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from components.interfaces.maths import absolute, both, cos, either, fmax, fmin, negate, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record

KEEP, OUT, BESIDE, BACK = range(4)
"""Phases: in the own lane, changing out, in the adjacent lane, changing back."""

_FAR = 1e6
_ANYWHERE = 1e12
"""[m] Every place is nearer, but no number that is none."""
_SLOWEST_CLOSING = 0.1
"""[m/s] An obstacle that the ego gains on more slowly than this does not block it."""


@record
class Manoeuvre:
    """What the planner remembers from sample to sample."""

    phase: float = quantity("1", "phase: 0 own lane, 1 changing out, 2 adjacent lane, 3 changing back")
    planned: float = quantity("1", "1 once a lane change has been planned, else 0")
    located: float = quantity("1", "1 once the first sample has set the start of the path, else 0")
    x_0: float = quantity("m", "start of the path, P0")
    x_1: float = quantity("m", "where the change out begins, P1")
    x_8: float = quantity("m", "where the change back begins, P8")
    x_o: float = quantity("m", "boundary corner of the obstacle that is passed first, along the road")
    y_o: float = quantity("m", "boundary corner of the obstacle that is passed first, across the road")


@record
class Lanes:
    """The lanes, and how early a lane change has to be complete."""

    y_lane: float = quantity("m", "centre of the ego's own lane")
    y_adjacent: float = quantity("m", "centre of the adjacent lane")
    v_ref: float = quantity("m/s", "speed the path is planned for")
    l_before: float = quantity("m", "distance before an obstacle's centre at which the change out is complete")
    l_after: float = quantity("m", "distance behind an obstacle's centre at which the return begins")
    l_sight: float = quantity("m", "distance ahead in which obstacles are considered")
    l_change: float = quantity("m", "length of one lane change along the road")
    l_gap: float = quantity("m", "safety gap around an obstacle")


def no_manoeuvre() -> Manoeuvre:
    """Nothing planned yet."""
    return Manoeuvre(phase=float(KEEP), planned=0.0, located=0.0, x_0=0.0, x_1=0.0, x_8=0.0, x_o=0.0, y_o=0.0)


@dataclass(frozen=True)
class Blockade:
    """What blocks the own lane, and where that asks for the changes."""

    blocked: bool
    x_1: float
    x_8: float
    stays: bool
    """Whether something leaves no room for a return before `x_8`."""
    corner: tuple[float, float]


def plan(lanes: Lanes, before: Manoeuvre, ego: VehicleState, obstacles: ObstacleList) -> Manoeuvre:
    """The manoeuvre seen from this sample."""
    keep = before.phase <= KEEP
    known = both(keep, before.planned > 0)
    finished = both(known, ego.x >= before.x_8 + lanes.l_change)
    pending = both(known, negate(finished))  # planned, but not begun
    soonest_return = fmax(ego.x, before.x_1 + lanes.l_change)
    ahead = _blockade(lanes, ego, obstacles, keep, soonest_return)

    begins = both(keep, ahead.blocked)
    located = absolute(ego.x) < _ANYWHERE
    x_0 = where(before.located, before.x_0, where(located, ego.x, 0.0))
    x_0 = where(both(begins, finished), ego.x, x_0)  # a new episode
    earliest = where(pending, fmin(before.x_1, ego.x), ego.x)  # a change that is due does not move on with the ego
    x_1 = where(begins, fmax(ahead.x_1, earliest), before.x_1)
    x_7 = x_1 + lanes.l_change
    changed = where(ahead.stays, fmax(ahead.x_8, x_7), fmax(before.x_8, x_7))
    x_8 = where(before.phase < BACK, changed, before.x_8)
    dropped = both(pending, negate(begins))  # what blocked the lane has gone before the change began

    phase = where(both(begins, ego.x >= x_1), float(OUT), before.phase)
    phase = where(both(phase == OUT, ego.x >= x_7), float(BESIDE), phase)
    phase = where(both(phase == BESIDE, ego.x >= x_8), float(BACK), phase)
    phase = where(both(phase == BACK, ego.x >= x_8 + lanes.l_change), float(KEEP), phase)
    return Manoeuvre(
        phase=phase,
        planned=where(begins, 1.0, where(dropped, 0.0, before.planned)),
        located=where(located, 1.0, before.located),
        x_0=x_0,
        x_1=x_1,
        x_8=x_8,
        x_o=where(begins, ahead.corner[0], before.x_o),
        y_o=where(begins, ahead.corner[1], before.y_o),
    )


def _blockade(
    lanes: Lanes,
    ego: VehicleState,
    obstacles: ObstacleList,
    keep: bool,  # noqa: FBT001 - a condition of the equations
    soonest_return: float,
) -> Blockade:
    """What blocks the own lane; once out of it, only what the return at `soonest_return` would run into counts."""
    half_lane = absolute(lanes.y_adjacent - lanes.y_lane) / 2
    side = where(lanes.y_adjacent < lanes.y_lane, -1.0, 1.0)
    reached: list[tuple[bool, float, float]] = []
    first, corner_x, corner_y = _FAR, _FAR, lanes.y_lane
    for i in range(SLOTS):
        closing = lanes.v_ref - obstacles.v[i] * cos(obstacles.psi[i])
        caught = both(closing > _SLOWEST_CLOSING, absolute(obstacles.y[i] - lanes.y_lane) < half_lane)
        stretch = lanes.v_ref / fmax(closing, _SLOWEST_CLOSING)
        x_1 = ego.x + stretch * (obstacles.x[i] - lanes.l_before - ego.x) - lanes.l_change
        x_8 = ego.x + stretch * (obstacles.x[i] + lanes.l_after - ego.x)
        ahead = both(x_8 > ego.x, x_1 < ego.x + lanes.l_sight)
        blocks = both(obstacles.valid[i], both(caught, ahead))
        reached.append((blocks, x_1, x_8))
        nearer = both(blocks, x_1 < first)
        first = where(nearer, x_1, first)
        corner_x = where(nearer, obstacles.x[i] - obstacles.length[i] / 2 - lanes.l_gap, corner_x)
        corner_y = where(nearer, obstacles.y[i] + side * (obstacles.width[i] / 2 + lanes.l_gap), corner_y)

    blocked = reached[0][0]
    for blocks, _, _ in reached[1:]:
        blocked = either(blocked, blocks)
    soonest = where(keep, first, soonest_return)
    back = soonest
    for _ in range(SLOTS):  # each round passes at least one more of the obstacles that leave no room for a return
        for blocks, x_1, x_8 in reached:
            back = where(both(blocks, x_1 < back + lanes.l_change), fmax(back, x_8), back)
    return Blockade(blocked=blocked, x_1=first, x_8=back, stays=back > soonest, corner=(corner_x, corner_y))
