"""Obstacles on straight lines that ramp from a start speed to a final speed: what blocks of the traffic share."""

from __future__ import annotations

from typing import ClassVar

from components.interfaces.frames import to_road
from components.interfaces.maths import Array, absolute, fmin, sign, vector
from components.interfaces.quantity import boolean, quantity
from components.interfaces.record import record
from components.interfaces.sockets import TrafficInputs


@record
class RampState:
    """Distance travelled and speed of each obstacle."""

    s: Array = quantity("m", "distance travelled", shape=("N_o",))
    v: Array = quantity("m/s", "speed", shape=("N_o",))


@record
class Ramps:
    """N_o places for an obstacle, and how each moves; the equations stand in `ramp_traffic`."""

    N_o: ClassVar[int]

    valid: Array = boolean("whether the slot holds an obstacle", shape=("N_o",))
    x_start: Array = quantity("m", "initial position along the road", shape=("N_o",))
    y_start: Array = quantity("m", "initial position across the road", shape=("N_o",))
    psi_start: Array = quantity("rad", "yaw angle", shape=("N_o",))
    v_start: Array = quantity("m/s", "initial speed", shape=("N_o",), min=0)
    v_final: Array = quantity("m/s", "speed after the ramp", shape=("N_o",), min=0)
    a: Array = quantity("m/s2", "magnitude of the acceleration on the ramp", shape=("N_o",), min=0)
    length: Array = quantity("m", "length of the box", shape=("N_o",), min=0)
    width: Array = quantity("m", "width of the box", shape=("N_o",), min=0)

    def start(self) -> RampState:
        """Nothing travelled, at the start speeds."""
        return RampState(s=0.0 * self.v_start, v=self.v_start)

    def places(self, x: RampState) -> tuple[Array, Array]:
        """Where the obstacles are now, along and across the road [m]."""
        moved = [to_road(self.psi_start[i], x.s[i], 0.0) for i in range(self.N_o)]
        return (
            vector([self.x_start[i] + dx for i, (dx, _) in enumerate(moved)]),
            vector([self.y_start[i] + dy for i, (_, dy) in enumerate(moved)]),
        )

    def step(self, x: RampState, u: TrafficInputs, h: float) -> RampState:  # noqa: ARG002 - nobody reacts to the ego
        """The exact motion over `h`."""
        moved = [self._ramp(x.s[i], x.v[i], self.v_final[i], self.a[i], h) for i in range(self.N_o)]
        return RampState(s=vector([s for s, _ in moved]), v=vector([v for _, v in moved]))

    @staticmethod
    def _ramp(s: float, v: float, v_final: float, a: float, h: float) -> tuple[float, float]:
        change = fmin(absolute(v_final - v), a * h) * sign(v_final - v)  # a_r t_r
        t_r = fmin(h, absolute(change) / (a + (a <= 0)))  # 0 / 1 where there is no ramp
        return s + v * h + change * (h - t_r / 2), v + change
