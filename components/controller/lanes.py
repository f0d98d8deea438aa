"""The lanes of the road, the ways from the own lane into another one, and who is in them.

The own lane may have one neighbour, the *adjacent* lane, or the road has a *third* lane next to one of the two: on the
other side of the own lane, or beyond the adjacent lane, which a change then crosses.
"""

from __future__ import annotations

from dataclasses import dataclass

from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from components.interfaces.maths import absolute, both, cos, either, fmin, negate, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record


@record
class Lanes:
    """The lanes, and how early a lane change has to be complete."""

    y_lane: float = quantity("m", "centre of the ego's own lane")
    y_adjacent: float = quantity("m", "centre of the adjacent lane")
    y_third: float = quantity("m", "centre of the third lane; that of the adjacent lane where there is none")
    v_ref: float = quantity("m/s", "speed the path is planned for")
    l_before: float = quantity("m", "distance before an obstacle's centre at which the change out is complete")
    l_after: float = quantity("m", "distance behind an obstacle's centre at which the return begins")
    l_sight: float = quantity("m", "distance ahead in which obstacles are considered")
    l_change: float = quantity("m", "length of a change to the adjacent lane along the road")
    l_third: float = quantity("m", "length of a change to the third lane along the road")
    l_gap: float = quantity("m", "safety gap around an obstacle")
    x_task: float = quantity("m", "where a lane change is asked for as if an obstacle stood there")
    l_clear: float = quantity("m", "least distance between centres, along the road, from others in a lane that is free")
    a_follow: float = quantity("m/s2", "braking that the speed behind an obstacle counts on")


@dataclass(frozen=True)
class Way:
    """A way from the own lane into another one, and back."""

    y: float
    """Centre of the other lane [m]."""
    length: float
    """Length of either change along the road [m]."""
    crosses: bool
    """Whether it crosses the adjacent lane."""


def to_adjacent(lanes: Lanes) -> Way:
    """The way into the adjacent lane."""
    return Way(lanes.y_adjacent, lanes.l_change, crosses=False)


def to_third(lanes: Lanes) -> Way:
    """The way into the third lane."""
    beyond = (lanes.y_third - lanes.y_adjacent) * (lanes.y_adjacent - lanes.y_lane) > 0
    return Way(lanes.y_third, lanes.l_third, crosses=beyond)


def has_third(lanes: Lanes) -> bool:
    """Whether there is a third lane."""
    return absolute(lanes.y_third - lanes.y_adjacent) > 0


def third_lane(y_lane: float, y_adjacent: float, y_third: float) -> float:
    """The centre of the third lane; that of the adjacent lane where the value does not lie next to one of the two.

    A lane is next to another one whose centre is between half and one and a half times as far away as the centres of
    the own and the adjacent lane are from each other.

    Args:
        y_lane: Centre of the own lane [m].
        y_adjacent: Centre of the adjacent lane [m].
        y_third: What is said of the third [m].
    """
    width = absolute(y_adjacent - y_lane)
    distance = fmin(absolute(y_third - y_lane), absolute(y_third - y_adjacent))
    return where(both(distance > width / 2, distance < 1.5 * width), y_third, y_adjacent)


def in_lane(lanes: Lanes, y_obstacle: float, y: float) -> bool:
    """Whether an obstacle at `y_obstacle` [m] is in the lane at `y` [m]."""
    return absolute(y_obstacle - y) < absolute(lanes.y_adjacent - lanes.y_lane) / 2


def is_free(  # noqa: PLR0913 - a lane, a stretch of it, and its traffic
    lanes: Lanes, ego: VehicleState, obstacles: ObstacleList, y: float, x_from: float, x_to: float, l_clear: float
) -> bool:
    """Whether a lane is free for a stretch of the road.

    It is when nobody in it, going on at the present speed, comes closer than `l_clear` while the ego drives the stretch
    at `v_ref`.

    Args:
        lanes: The lanes.
        ego: The vehicle of this instant.
        obstacles: The traffic of this instant.
        y: Centre of the lane [m].
        x_from: Where the stretch begins [m].
        x_to: Where it ends [m].
        l_clear: Least distance between centres, along the road [m].
    """
    free: bool = lanes.v_ref > 0  # true, but a symbol where the equations are symbolic
    for i in range(SLOTS):
        v = obstacles.v[i] * cos(obstacles.psi[i])
        first, last = (obstacles.x[i] + v * (x - ego.x) / lanes.v_ref - x for x in (x_from, x_to))
        apart = both(first * last > 0, fmin(absolute(first), absolute(last)) >= l_clear)
        there = both(obstacles.valid[i], in_lane(lanes, obstacles.y[i], y))
        free = both(free, either(negate(there), apart))
    return free


def crossing_is_free(  # noqa: PLR0913 - a way, its place, and the traffic
    lanes: Lanes, way: Way, ego: VehicleState, obstacles: ObstacleList, x: float, l_clear: float
) -> bool:
    """Whether the lane between is free, where there is one, for a change that begins at `x` [m]."""
    sixth = way.length / 6  # in the first and the last sixth of the change the ego is in one of the outer lanes
    free = is_free(lanes, ego, obstacles, lanes.y_adjacent, x + sixth, x + 5 * sixth, l_clear)
    return either(negate(way.crosses), free)
