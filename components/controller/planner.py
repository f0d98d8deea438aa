"""When to change lanes: where the path's waypoints lie, decided anew at every sample from the traffic of the moment.

Every obstacle in the ego's own lane that the ego would catch up with at `v_ref` blocks it. With closing speed c, the
ego is `l_before` behind it after travelling ``v_ref (x_o - l_before - x) / c`` and `l_after` ahead of it after
``v_ref (x_o + l_after - x) / c``: the change out is complete at the first, the return begins at the second. Obstacles
too close behind each other for a return between them are passed in one manoeuvre. `x_task` asks for a lane change as
if an obstacle stood there. A change that is needed at once begins at the ego; one that has not begun is dropped when it
is no longer needed.

A lane is free for a stretch of the road when no obstacle in it, going on at its present speed, comes closer than
`l_clear` (centre to centre) while the ego drives that stretch at `v_ref`:

* the change out begins only where the adjacent lane is free from the first third of the change out to the last third
  of the return, and the own lane for the rest of the return; until then the ego keeps its lane and adapts its speed
  to the obstacle ahead;
* a change that has begun is finished (RESOLUTIONS 22);
* the return begins only where the own lane is free; until then the ego stays in the adjacent lane, behind the obstacle
  ahead of it there.

A change that is planned, and the return of one that has begun, need less room than a new one (hysteresis), so that the
decision does not change back and forth with small changes of the traffic.

The speed behind an obstacle leaves room to brake to its speed with `a_follow`, `l_before` behind it:
``v_d = sqrt(v_o^2 + 2 a_follow (gap - l_before))``, at most `v_ref`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from components.interfaces.maths import absolute, both, cos, either, fmax, fmin, is_number, negate, sqrt, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record

KEEP, OUT, BESIDE, BACK = range(4)
"""Phases: in the own lane, changing out, in the adjacent lane, changing back."""

_FAR = 1e6
"""[m] Further away than anything that a decision depends on."""
_FARTHEST = 1e12
"""[m] A position beyond this is not a number that the path can start from."""
_HYSTERESIS = 0.8
"""Share of `l_clear` that is enough to keep a change that is planned, or to return from one that has begun."""
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
    v_d: float = quantity("m/s", "speed to drive at: v_ref, or less behind an obstacle that cannot be passed")


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
    x_task: float = quantity("m", "where a lane change is asked for as if an obstacle stood there")
    l_clear: float = quantity("m", "least distance between centres, along the road, from others in a lane that is free")
    a_follow: float = quantity("m/s2", "braking that the speed behind an obstacle counts on")


def no_manoeuvre() -> Manoeuvre:
    """The manoeuvre before the first sample: none is planned."""
    return Manoeuvre(phase=float(KEEP), planned=0.0, located=0.0, x_0=0.0, x_1=0.0, x_8=0.0, x_o=0.0, y_o=0.0, v_d=0.0)


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


def plan(lanes: Lanes, before: Manoeuvre, ego: VehicleState, obstacles: ObstacleList) -> Manoeuvre:
    """The manoeuvre after this sample.

    Args:
        lanes: The lanes, and how early a lane change has to be complete.
        before: The manoeuvre after the previous sample.
        ego: The vehicle of this instant.
        obstacles: The traffic of this instant.
    """
    keep = before.phase <= KEEP
    known = both(keep, before.planned > 0)
    finished = both(known, ego.x >= before.x_8 + lanes.l_change)
    pending = both(known, negate(finished))  # planned, but not begun
    soonest_return = fmax(ego.x, before.x_1 + lanes.l_change)
    ahead = _blockade(lanes, ego, obstacles, keep, soonest_return)

    earliest = where(pending, fmin(before.x_1, ego.x), ego.x)  # the start of a change that is due stays where it is
    x_out = fmax(ahead.x_1, earliest)
    x_11 = fmax(ahead.x_8, x_out + lanes.l_change) + lanes.l_change
    l_clear = where(pending, _HYSTERESIS * lanes.l_clear, lanes.l_clear)
    begins = both(both(keep, ahead.blocked), _may_leave(lanes, ego, obstacles, x_out, x_11, l_clear))
    located = is_number(ego.x, limit=_FARTHEST)
    x_0 = where(before.located, before.x_0, where(located, ego.x, 0.0))
    x_0 = where(both(begins, finished), ego.x, x_0)  # a new episode
    x_1 = where(begins, x_out, before.x_1)
    x_7 = x_1 + lanes.l_change
    changed = where(ahead.stays, fmax(ahead.x_8, x_7), fmax(before.x_8, x_7))
    open_end = both(before.phase > KEEP, before.phase < BACK)  # a return that is behind the ego is never opened again
    x_8 = where(either(begins, open_end), changed, before.x_8)
    here = fmax(x_8, ego.x)
    may_return = _may_return(lanes, ego, obstacles, here)
    x_8 = where(both(before.phase == BESIDE, negate(may_return)), here, x_8)
    dropped = both(pending, negate(begins))  # what blocked the lane has gone before the change began

    phase = where(both(begins, ego.x >= x_1), float(OUT), before.phase)
    phase = _advanced(phase, ego.x, x_7, x_8, x_8 + lanes.l_change, may_return)
    return Manoeuvre(
        phase=phase,
        planned=where(begins, 1.0, where(dropped, 0.0, before.planned)),
        located=where(located, 1.0, before.located),
        x_0=x_0,
        x_1=x_1,
        x_8=x_8,
        x_o=where(begins, ahead.corner[0], before.x_o),
        y_o=where(begins, ahead.corner[1], before.y_o),
        v_d=_speed(lanes, ego, obstacles, phase, both(keep, negate(begins)), x_8 + lanes.l_change),
    )


def _may_leave(  # noqa: PLR0913 - the lanes, their traffic, and the manoeuvre
    lanes: Lanes, ego: VehicleState, obstacles: ObstacleList, x_out: float, x_11: float, l_clear: float
) -> bool:
    """Whether both lanes are free for a change out that begins at `x_out` and a return that ends at `x_11`."""
    third = lanes.l_change / 3  # in the first third of a change the ego has not reached the other lane
    return both(
        _is_free(lanes, ego, obstacles, lanes.y_adjacent, x_out + third, x_11 - third, l_clear),
        _is_free(lanes, ego, obstacles, lanes.y_lane, x_11 - 2 * third, x_11, l_clear),
    )


def _may_return(lanes: Lanes, ego: VehicleState, obstacles: ObstacleList, x: float) -> bool:
    """Whether the own lane is free for a return that begins at `x`."""
    third = lanes.l_change / 3
    return _is_free(lanes, ego, obstacles, lanes.y_lane, x + third, x + 3 * third, _HYSTERESIS * lanes.l_clear)


def _advanced(  # noqa: PLR0913 - where the phases end
    phase: float,
    x: float,
    x_7: float,
    x_8: float,
    x_11: float,
    may_return: bool,  # noqa: FBT001 - a condition of the equations
) -> float:
    """The phase at `x`, after a phase that may have ended by now."""
    phase = where(both(phase == OUT, x >= x_7), float(BESIDE), phase)
    phase = where(both(both(phase == BESIDE, x >= x_8), may_return), float(BACK), phase)
    return where(both(phase == BACK, x >= x_11), float(KEEP), phase)


def _in_lane(lanes: Lanes, y_obstacle: float, y: float) -> bool:
    return absolute(y_obstacle - y) < absolute(lanes.y_adjacent - lanes.y_lane) / 2


def _is_free(  # noqa: PLR0913 - a lane, a stretch of it, and its traffic
    lanes: Lanes, ego: VehicleState, obstacles: ObstacleList, y: float, x_from: float, x_to: float, l_clear: float
) -> bool:
    """Whether the lane at `y` is free while the ego drives from `x_from` to `x_to`."""
    free: bool = lanes.v_ref > 0  # true, but a symbol where the equations are symbolic
    for i in range(SLOTS):
        v = obstacles.v[i] * cos(obstacles.psi[i])
        first, last = (obstacles.x[i] + v * (x - ego.x) / lanes.v_ref - x for x in (x_from, x_to))
        apart = both(first * last > 0, fmin(absolute(first), absolute(last)) >= l_clear)
        there = both(obstacles.valid[i], _in_lane(lanes, obstacles.y[i], y))
        free = both(free, either(negate(there), apart))
    return free


def _speed(  # noqa: PLR0913 - everything the speed depends on
    lanes: Lanes,
    ego: VehicleState,
    obstacles: ObstacleList,
    phase: float,
    waits: bool,  # noqa: FBT001 - a condition of the equations
    x_11: float,
) -> float:
    """The speed that leaves room behind an obstacle that cannot be passed (yet)."""
    v_d = lanes.v_ref
    beside = phase == BESIDE
    for i in range(SLOTS):
        v = obstacles.v[i] * cos(obstacles.psi[i])
        gap = obstacles.x[i] - ego.x
        at_return = obstacles.x[i] + v * (x_11 - ego.x) / lanes.v_ref - x_11
        own = both(waits, _in_lane(lanes, obstacles.y[i], lanes.y_lane))
        adjacent = both(both(beside, _in_lane(lanes, obstacles.y[i], lanes.y_adjacent)), at_return < lanes.l_clear)
        leads = both(both(obstacles.valid[i], gap > 0), either(own, adjacent))
        v_behind = sqrt(v * v + 2 * lanes.a_follow * fmax(gap - lanes.l_before, 0.0))
        v_d = where(leads, fmin(v_d, v_behind), v_d)
    return v_d


def _blockade(
    lanes: Lanes,
    ego: VehicleState,
    obstacles: ObstacleList,
    keep: bool,  # noqa: FBT001 - a condition of the equations
    soonest_return: float,
) -> Blockade:
    """What blocks the own lane; once the ego is out of it, only obstacles in the way of the return count."""
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

    x_task = lanes.x_task - lanes.l_before - lanes.l_change, lanes.x_task + lanes.l_after
    requested = both(x_task[1] > ego.x, x_task[0] < ego.x + lanes.l_sight)
    reached.append((requested, *x_task))
    nearer = both(requested, x_task[0] < first)
    first = where(nearer, x_task[0], first)
    corner_x, corner_y = where(nearer, lanes.x_task, corner_x), where(nearer, lanes.y_lane, corner_y)

    blocked = reduce(either, (blocks for blocks, _, _ in reached))
    soonest = where(keep, first, soonest_return)
    back = soonest
    for _ in range(SLOTS):  # each round passes at least one more of the obstacles that leave no room for a return
        for blocks, x_1, x_8 in reached:
            back = where(both(blocks, x_1 < back + lanes.l_change), fmax(back, x_8), back)
    return Blockade(blocked=blocked, x_1=first, x_8=back, stays=back > soonest, corner=(corner_x, corner_y))
