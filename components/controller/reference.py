"""The reference of a sample: the manoeuvre that the traffic requires, its Dubins path, and the corridor around it.

Blocks that plan a path inherit `PathPlanning`; those that also predict inherit `Guidance`.
"""

from __future__ import annotations

from typing import ClassVar

from components.controller import dubins
from components.controller.corridor import Road, corridor
from components.controller.lanes import Lanes, third_lane
from components.controller.planner import Manoeuvre, plan
from components.controller.problems.ocp import Horizon
from components.interfaces.buses import ObstacleList, VehicleState, Waypoints
from components.interfaces.maths import absolute, both, fmax, negate, sin, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.sockets import ControllerInputs

_LEAST_ANGLE = 1e-6
"""[rad] The arcs of a change between lanes that lie in one place have none."""


@record
class PathReference:
    """The manoeuvre, the path and the prediction steps' references of one sample."""

    manoeuvre: Manoeuvre
    path: Waypoints
    horizon: Horizon


@record
class PathPlanning:
    """When to change lanes, and the Dubins path of it."""

    mu: float = quantity("1", "friction coefficient the path is planned for", min=0.01, max=2)
    g: float = quantity("m/s2", "gravity", min=0.1)
    v_ref: float = quantity("m/s", "speed the path is planned for", min=1)
    y_lane: float = quantity("m", "centre of the ego's own lane")
    y_adjacent: float = quantity("m", "centre of the adjacent lane")
    y_third: float = quantity("m", "centre of a third lane beside one of the two; far from both where there is none")
    l_d: float = quantity("m", "length of the diagonal of a lane change", min=0)
    l_before: float = quantity("m", "distance before an obstacle's centre at which the change out is complete", min=0)
    l_after: float = quantity("m", "distance behind an obstacle's centre at which the return begins", min=0)
    x_task: float = quantity("m", "where a lane change is asked for as if an obstacle stood there")
    l_clear: float = quantity("m", "least distance between centres from others in a lane that is free", min=0)
    a_follow: float = quantity("m/s2", "braking that the speed behind an obstacle counts on", min=0)
    l_sight: float = quantity("m", "distance ahead in which obstacles are considered", min=0)
    l_end: float = quantity("m", "length of the path beyond the last lane change", min=0)
    l_gap: float = quantity("m", "safety gap around an obstacle", min=0)

    def radius(self) -> float:
        """Radius of the arcs of a lane change [m]."""
        return dubins.radius(self.v_ref, self.mu, self.g)

    def third(self) -> float:
        """Centre of the third lane [m]; that of the adjacent lane where there is none."""
        return third_lane(self.y_lane, self.y_adjacent, self.y_third)

    def shape(self, third: float = 0.0) -> dubins.LaneChange:
        """One lane change of the path: to the adjacent lane, or to the third where `third` is 1.

        A wider one has the same arcs and a longer diagonal, so that it is no harder to follow.
        """
        one = dubins.LaneChange(w=self.y_adjacent - self.y_lane, R=self.radius(), l_d=self.l_d)
        w = where(third > 0, self.third() - self.y_lane, one.w)
        wider = fmax(absolute(w) - absolute(one.w), 0.0)
        return dubins.LaneChange(w=w, R=one.R, l_d=self.l_d + wider / fmax(sin(one.theta), _LEAST_ANGLE))

    def manoeuvre(self, before: Manoeuvre, u: ControllerInputs) -> Manoeuvre:
        """The manoeuvre seen from this sample."""
        lanes = Lanes(
            y_lane=self.y_lane,
            y_adjacent=self.y_adjacent,
            y_third=self.third(),
            v_ref=self.v_ref,
            l_before=self.l_before,
            l_after=self.l_after,
            l_sight=self.l_sight,
            l_change=self.shape().length,
            l_third=self.shape(1.0).length,
            l_gap=self.l_gap,
            x_task=self.x_task,
            l_clear=self.l_clear,
            a_follow=self.a_follow,
        )
        return plan(lanes, before, u.ego, u.obstacles)

    def path(self, manoeuvre: Manoeuvre, ego: VehicleState) -> dubins.Path:
        """The path of a manoeuvre; the straight lane, with all waypoints on it, while none is planned."""
        planned = self.shape(manoeuvre.third)
        shape = dubins.LaneChange(w=where(manoeuvre.planned > 0, planned.w, 0.0), R=planned.R, l_d=planned.l_d)
        idle = manoeuvre.planned <= 0
        x_1 = where(idle, manoeuvre.x_0, manoeuvre.x_1)
        x_8 = where(idle, manoeuvre.x_0 + shape.length, manoeuvre.x_8)
        x_14 = fmax(x_8 + shape.length, ego.x) + self.l_end
        corner = (manoeuvre.x_o, manoeuvre.y_o)
        return dubins.double_lane_change(
            shape, x_0=manoeuvre.x_0, x_1=x_1, x_8=x_8, x_14=x_14, y_lane=self.y_lane, corner=corner
        )


@record
class Guidance(PathPlanning):
    """The path, and the references of N_p prediction steps on it and in the corridor."""

    N_p: ClassVar[int]

    dt: float = quantity("s", "prediction step t(k+i) - t(k+i-1)", min=0.01, max=1)
    y_left: float = quantity("m", "left edge of the road")
    y_right: float = quantity("m", "right edge of the road")
    l_ramp: float = quantity("m", "length of the corridor's ramp before and behind an obstacle", min=0.1)

    def progress(self, v: float, v_d: float, t: float) -> float:
        """How far along the path [m] the desired point is after `t` [s] at speed `v` now, `v_d` desired [m/s].

        It slows down no faster than with `a_follow` in steps of `dt`, as the predicted vehicle can: a point that
        suddenly is much nearer than the vehicle can be would be reached by leaving the path.
        """
        return fmax(v_d * t, v * t - self.a_follow * t * (t + self.dt) / 2)

    def beside(self, obstacles: ObstacleList, y_d: float) -> ObstacleList:  # noqa: ARG002 - a subclass may need it
        """The obstacles that narrow the corridor where the path is at `y_d`: all of them."""
        return obstacles

    def parting(self, manoeuvre: Manoeuvre, y_d: float) -> float:
        """The line [m] that parts obstacles on the left from those on the right, where the path is at `y_d` [m].

        It is the middle of a road with two lanes. On one with three lanes it is the line that a change crosses: that
        between the own lane and the one that is changed to, or beyond the adjacent lane, that between the next two.
        """
        third = self.third()
        beyond = (third - self.y_adjacent) * (self.y_adjacent - self.y_lane) > 0
        is_far = both(beyond, absolute(y_d - self.y_lane) > absolute(self.y_adjacent - self.y_lane))
        first = (self.y_lane + where(both(manoeuvre.third > 0, negate(beyond)), third, self.y_adjacent)) / 2
        crossed = where(is_far, (self.y_adjacent + third) / 2, first)
        return where(absolute(third - self.y_adjacent) > 0, crossed, (self.y_left + self.y_right) / 2)

    def reference(self, before: Manoeuvre, u: ControllerInputs) -> PathReference:
        """Manoeuvre, path and corridor of this sample (lines 2 and 3 of Algorithm 1).

        The desired point X_d(k+i) is `progress` along the path from the projection of the ego on it (RESOLUTIONS 13).
        """
        manoeuvre = self.manoeuvre(before, u)
        path = self.path(manoeuvre, u.ego)
        s = path.project(u.ego.x, u.ego.y)
        ahead = [self.progress(u.ego.v_x, manoeuvre.v_d, self.dt * (i + 1)) for i in range(self.N_p)]
        points = [path.point(s + distance) for distance in ahead]
        road = Road(y_left=self.y_left, y_right=self.y_right, l_gap=self.l_gap, l_ramp=self.l_ramp)
        free = [
            corridor(road, self.beside(u.obstacles, y_d), x_d, self.dt * (i + 1), self.parting(manoeuvre, y_d))
            for i, (x_d, y_d) in enumerate(points)
        ]
        horizon = Horizon(
            x_d=vector([x_d for x_d, _ in points]),
            y_d=vector([y_d for _, y_d in points]),
            y_upper=vector([upper for upper, _ in free]),
            y_lower=vector([lower for _, lower in free]),
        )
        return PathReference(manoeuvre=manoeuvre, path=path.waypoints, horizon=horizon)
