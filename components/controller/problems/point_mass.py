"""The optimal control problem of a planner that knows the vehicle as a point mass only.

    minimise over a_x(k..k+N_p-1), a_y(k..k+N_p-1) the distances of (5): to the path, to the boundaries

    subject to  -mu g <= a_x, a_y <= mu g

with v(k+i) = v(k+i-1) + a dt and the position moved by the new velocity, as the prediction of `ocp` does. All vectors
are in the road frame. The variables are a_x / (mu g), then a_y / (mu g).
"""

from __future__ import annotations

from typing import Any

from components.controller.problems.ocp import Horizon, Weights, by_input, distance_cost
from components.interfaces.maths import Array, vector
from components.interfaces.quantity import quantity
from components.interfaces.record import record


@record
class PointMass:
    """Where the point mass is, and how it moves."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    v_x: float = quantity("m/s", "speed along the road")
    v_y: float = quantity("m/s", "speed across the road")

    def moved(self, a_x: float, a_y: float, t: float) -> PointMass:
        """The point mass `t` later, at a constant acceleration."""
        return PointMass(
            x=self.x + self.v_x * t + a_x * t * t / 2,
            y=self.y + self.v_y * t + a_y * t * t / 2,
            v_x=self.v_x + a_x * t,
            v_y=self.v_y + a_y * t,
        )


@record
class PlanningProblem:
    """The optimal control problem of one sample."""

    weights: Weights
    horizon: Horizon
    start: PointMass
    dt: float = quantity("s", "prediction step")
    a_max: float = quantity("m/s2", "largest acceleration along each axis, mu g")

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of z, of shape (2 N_p,)."""
        n = 2 * self.horizon.steps
        return vector([-1.0] * n), vector([1.0] * n)

    def accelerations(self, z: Array) -> list[tuple[Any, Any]]:
        """(a_x, a_y) at k..k+N_p-1 for the scaled decision `z`."""
        along, across = by_input(z)
        return [(self.a_max * along[i], self.a_max * across[i]) for i in range(along.shape[0])]

    def prediction(self, z: Array) -> list[PointMass]:
        """The predicted states at k+1..k+N_p."""
        states: list[PointMass] = []
        now = self.start
        for a_x, a_y in self.accelerations(z):
            v_x, v_y = now.v_x + a_x * self.dt, now.v_y + a_y * self.dt
            now = PointMass(x=now.x + v_x * self.dt, y=now.y + v_y * self.dt, v_x=v_x, v_y=v_y)
            states.append(now)
        return states

    def cost(self, z: Array) -> float:
        """The distances of (5), without the yaw acceleration."""
        total = 0.0
        for i, at in enumerate(self.prediction(z)):
            total = total + distance_cost(self.weights, self.horizon, i, at.x, at.y)
        return total
