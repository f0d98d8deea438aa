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
* where the road has a third lane, and the adjacent lane is not free for the change but the third is, the change goes to
  the third; from one beyond the adjacent lane, that lane has to be free for the crossings, too. A change that is
  planned keeps its lane as long as that is free, one that has begun keeps it to its end;
* a change that has begun is finished (RESOLUTIONS 22);
* the return begins only where the own lane is free; until then the ego stays in the other lane, behind the obstacle
  ahead of it there.

A change that is planned, and the return of one that has begun, need less room than a new one (hysteresis), so that the
decision does not change back and forth with small changes of the traffic.

The speed behind an obstacle leaves room to brake to its speed with `a_follow`, `l_before` behind it:
``v_d = sqrt(v_o^2 + 2 a_follow (gap - l_before))``, at most `v_ref`.
"""

from __future__ import annotations

from dataclasses import dataclass

from components.controller.blockade import blockade
from components.controller.lanes import (
    Lanes,
    Way,
    crossing_is_free,
    has_third,
    in_lane,
    is_free,
    to_adjacent,
    to_third,
)
from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from components.interfaces.maths import both, cos, either, fmax, fmin, is_number, negate, sqrt, where
from components.interfaces.quantity import quantity
from components.interfaces.record import combine, record
from components.interfaces.staging import staged_if

KEEP, OUT, BESIDE, BACK = range(4)
"""Phases: in the own lane, changing out, in the other lane, changing back."""

_FARTHEST = 1e12
"""[m] A position beyond this is not a number that the path can start from."""
_HYSTERESIS = 0.8
"""Share of `l_clear` that is enough to keep a change that is planned, or to return from one that has begun."""


@record
class Manoeuvre:
    """What the planner remembers from sample to sample."""

    phase: float = quantity("1", "phase: 0 own lane, 1 changing out, 2 other lane, 3 changing back")
    planned: float = quantity("1", "1 once a lane change has been planned, else 0")
    located: float = quantity("1", "1 once the first sample has set the start of the path, else 0")
    x_0: float = quantity("m", "start of the path, P0")
    x_1: float = quantity("m", "where the change out begins, P1")
    x_8: float = quantity("m", "where the change back begins, P8")
    x_o: float = quantity("m", "boundary corner of the obstacle that is passed first, along the road")
    y_o: float = quantity("m", "boundary corner of the obstacle that is passed first, across the road")
    third: float = quantity("1", "1 where the change goes to the third lane, 0 where to the adjacent one")
    v_d: float = quantity("m/s", "speed to drive at: v_ref, or less behind an obstacle that cannot be passed")


@record
class _Planned:
    """What is planned by one of the ways into another lane."""

    manoeuvre: Manoeuvre
    begins: float = quantity("1", "1 where a change that is needed can be begun by it, now or later, else 0")


def no_manoeuvre() -> Manoeuvre:
    """The manoeuvre before the first sample: none is planned."""
    return Manoeuvre(
        phase=float(KEEP), planned=0.0, located=0.0, x_0=0.0, x_1=0.0, x_8=0.0, x_o=0.0, y_o=0.0, third=0.0, v_d=0.0
    )


@dataclass(frozen=True)
class _Seen:
    """What a sample sees, and what the planner remembers from the one before."""

    lanes: Lanes
    before: Manoeuvre
    ego: VehicleState
    obstacles: ObstacleList

    @property
    def keep(self) -> bool:
        """Whether the ego is in its own lane."""
        return self.before.phase <= KEEP

    @property
    def finished(self) -> bool:
        """Whether a manoeuvre is behind the ego."""
        length = where(self.before.third > 0, self.lanes.l_third, self.lanes.l_change)
        return both(both(self.keep, self.before.planned > 0), self.ego.x >= self.before.x_8 + length)

    @property
    def pending(self) -> bool:
        """Whether a change is planned, but has not begun."""
        return both(both(self.keep, self.before.planned > 0), negate(self.finished))

    def is_free(self, y: float, x_from: float, x_to: float, l_clear: float) -> bool:
        """Whether the lane at `y` is free for a stretch of the road."""
        return is_free(self.lanes, self.ego, self.obstacles, y, x_from, x_to, l_clear)

    def crossing_is_free(self, way: Way, x: float, l_clear: float) -> bool:
        """Whether the lane between is free for a change that begins at `x`."""
        return crossing_is_free(self.lanes, way, self.ego, self.obstacles, x, l_clear)


def plan(lanes: Lanes, before: Manoeuvre, ego: VehicleState, obstacles: ObstacleList) -> Manoeuvre:
    """The manoeuvre after this sample.

    Args:
        lanes: The lanes, and how early a lane change has to be complete.
        before: The manoeuvre after the previous sample.
        ego: The vehicle of this instant.
        obstacles: The traffic of this instant.
    """
    seen = _Seen(lanes, before, ego, obstacles)
    was_third = before.third > 0
    adjacent = _by_adjacent_lane(lanes, before, ego, obstacles)
    third = staged_if(has_third(lanes), _by_third_lane, _Planned, {}, lanes, before, ego, obstacles)
    prefers_third = either(negate(adjacent.begins > 0), both(seen.pending, was_third))
    takes_third = where(seen.keep, both(third.begins > 0, prefers_third), was_third)
    chosen = both(has_third(lanes), takes_third)

    def taken(by_third: float, by_adjacent: float) -> float:
        return where(chosen, by_third, by_adjacent)

    return combine(taken, third.manoeuvre, adjacent.manoeuvre)


def _by_adjacent_lane(lanes: Lanes, before: Manoeuvre, ego: VehicleState, obstacles: ObstacleList) -> _Planned:
    return _by_way(_Seen(lanes, before, ego, obstacles), to_adjacent(lanes), 0.0)


def _by_third_lane(lanes: Lanes, before: Manoeuvre, ego: VehicleState, obstacles: ObstacleList) -> _Planned:
    return _by_way(_Seen(lanes, before, ego, obstacles), to_third(lanes), 1.0)


def _by_way(seen: _Seen, way: Way, third: float) -> _Planned:
    """The manoeuvre if it goes by one way."""
    lanes, before, ego, obstacles = seen.lanes, seen.before, seen.ego, seen.obstacles
    keep = seen.keep
    pending = both(seen.pending, (before.third > 0) == (third > 0))  # by this way
    ahead = blockade(lanes, way, ego, obstacles, keep, fmax(ego.x, before.x_1 + way.length))

    earliest = where(pending, fmin(before.x_1, ego.x), ego.x)  # the start of a change that is due stays where it is
    x_out = fmax(ahead.x_1, earliest)
    x_11 = fmax(ahead.x_8, x_out + way.length) + way.length
    l_clear = where(pending, _HYSTERESIS * lanes.l_clear, lanes.l_clear)
    begins = both(both(keep, ahead.blocked), _may_leave(seen, way, x_out, x_11, l_clear))
    located, x_0 = _start(seen, begins)
    x_1 = where(begins, x_out, before.x_1)
    x_7 = x_1 + way.length
    changed = where(ahead.stays, fmax(ahead.x_8, x_7), fmax(before.x_8, x_7))
    open_end = both(before.phase > KEEP, before.phase < BACK)  # a return that is behind the ego is never opened again
    x_8 = where(either(begins, open_end), changed, before.x_8)
    here = fmax(x_8, ego.x)
    may_return = _may_return(seen, way, here)
    x_8 = where(both(before.phase == BESIDE, negate(may_return)), here, x_8)
    dropped = both(seen.pending, negate(begins))  # what blocked the lane has gone before the change began

    phase = where(both(begins, ego.x >= x_1), float(OUT), before.phase)
    phase = _advanced(phase, ego.x, x_7, x_8, x_8 + way.length, may_return)
    manoeuvre = Manoeuvre(
        phase=phase,
        planned=where(begins, 1.0, where(dropped, 0.0, before.planned)),
        located=where(located, 1.0, before.located),
        x_0=x_0,
        x_1=x_1,
        x_8=x_8,
        x_o=where(begins, ahead.corner[0], before.x_o),
        y_o=where(begins, ahead.corner[1], before.y_o),
        third=where(begins, third, before.third),
        v_d=_speed(seen, way, phase, both(keep, negate(begins)), x_8 + way.length),
    )
    return _Planned(manoeuvre=manoeuvre, begins=where(begins, 1.0, 0.0))


def _start(seen: _Seen, begins: bool) -> tuple[bool, float]:  # noqa: FBT001 - a condition of the equations
    """Whether the ego has a place in this sample, and where the path starts."""
    located = is_number(seen.ego.x, limit=_FARTHEST)
    x_0 = where(seen.before.located, seen.before.x_0, where(located, seen.ego.x, 0.0))
    return located, where(both(begins, seen.finished), seen.ego.x, x_0)  # a new episode


def _may_leave(seen: _Seen, way: Way, x_out: float, x_11: float, l_clear: float) -> bool:
    """Whether all lanes are free for a change out that begins at `x_out` and a return that ends at `x_11`."""
    third = way.length / 3  # in the first third of a change the ego has not reached the other lane
    return both(
        both(
            seen.is_free(way.y, x_out + third, x_11 - third, l_clear),
            seen.is_free(seen.lanes.y_lane, x_11 - 2 * third, x_11, l_clear),
        ),
        both(seen.crossing_is_free(way, x_out, l_clear), seen.crossing_is_free(way, x_11 - way.length, l_clear)),
    )


def _may_return(seen: _Seen, way: Way, x: float) -> bool:
    """Whether the own lane is free for a return that begins at `x`, and the lane between."""
    third, l_clear = way.length / 3, _HYSTERESIS * seen.lanes.l_clear
    own = seen.is_free(seen.lanes.y_lane, x + third, x + 3 * third, l_clear)
    return both(own, seen.crossing_is_free(way, x, l_clear))


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


def _speed(
    seen: _Seen,
    way: Way,
    phase: float,
    waits: bool,  # noqa: FBT001 - a condition of the equations
    x_11: float,
) -> float:
    """The speed that leaves room behind an obstacle that cannot be passed (yet)."""
    lanes, ego, obstacles = seen.lanes, seen.ego, seen.obstacles
    v_d = lanes.v_ref
    beside = phase == BESIDE
    for i in range(SLOTS):
        v = obstacles.v[i] * cos(obstacles.psi[i])
        gap = obstacles.x[i] - ego.x
        at_return = obstacles.x[i] + v * (x_11 - ego.x) / lanes.v_ref - x_11
        own = both(waits, in_lane(lanes, obstacles.y[i], lanes.y_lane))
        other = both(both(beside, in_lane(lanes, obstacles.y[i], way.y)), at_return < lanes.l_clear)
        leads = both(both(obstacles.valid[i], gap > 0), either(own, other))
        v_behind = sqrt(v * v + 2 * lanes.a_follow * fmax(gap - lanes.l_before, 0.0))
        v_d = where(leads, fmin(v_d, v_behind), v_d)
    return v_d
