"""The paper's traffic: obstacles that each change to a speed of their own and keep it."""

from __future__ import annotations

from typing import final

from components.interfaces.block import Block, block
from components.interfaces.buses import SLOTS, ObstacleList
from components.interfaces.frames import to_road
from components.interfaces.maths import Array, absolute, fmin, sign, vector
from components.interfaces.quantity import boolean, quantity
from components.interfaces.record import record
from components.interfaces.sockets import TRAFFIC, TrafficInputs, TrafficOutputs


@record
class RampState:
    """Distance travelled and speed of each obstacle."""

    s: Array = quantity("m", "distance travelled", shape=(SLOTS,))
    v: Array = quantity("m/s", "speed", shape=(SLOTS,))


@final
@block(TRAFFIC)
class RampTraffic(Block[TrafficInputs, RampState, TrafficOutputs]):
    """Obstacles on straight lines that ramp from a start speed to a final speed.

    Each slot holds one obstacle; it changes its speed by `a` until it has reached `v_final` and keeps it
    (static: all speeds zero). The motion within a step is exact, whatever the step:
    with t_r = min(h, |v_final - v| / a) and the signed acceleration a_r,
    ``v' = v + a_r t_r`` and ``s' = s + v h + a_r t_r (h - t_r / 2)``.

    It does not react to `ego`. An obstacle with `a = 0` keeps its start speed.
    """

    valid: Array = boolean("whether the slot holds an obstacle", shape=(SLOTS,))
    x_start: Array = quantity("m", "initial position along the road", shape=(SLOTS,))
    y_start: Array = quantity("m", "initial position across the road", shape=(SLOTS,))
    psi_start: Array = quantity("rad", "yaw angle", shape=(SLOTS,))
    v_start: Array = quantity("m/s", "initial speed", shape=(SLOTS,), min=0)
    v_final: Array = quantity("m/s", "speed after the ramp", shape=(SLOTS,), min=0)
    a: Array = quantity("m/s2", "magnitude of the acceleration on the ramp", shape=(SLOTS,), min=0)
    length: Array = quantity("m", "length of the box", shape=(SLOTS,), min=0)
    width: Array = quantity("m", "width of the box", shape=(SLOTS,), min=0)

    def start(self) -> RampState:
        """Nothing travelled, at the start speeds."""
        return RampState(s=0.0 * self.v_start, v=self.v_start)

    def output(self, x: RampState, u: TrafficInputs) -> TrafficOutputs:  # noqa: ARG002 - it does not react to the ego vehicle
        """Where the obstacles are now."""
        place = [to_road(self.psi_start[i], x.s[i], 0.0) for i in range(SLOTS)]
        return TrafficOutputs(
            obstacles=ObstacleList(
                valid=self.valid,
                id=vector([float(i + 1) for i in range(SLOTS)]),
                x=vector([self.x_start[i] + dx for i, (dx, _) in enumerate(place)]),
                y=vector([self.y_start[i] + dy for i, (_, dy) in enumerate(place)]),
                psi=self.psi_start,
                v=x.v,
                length=self.length,
                width=self.width,
            )
        )

    def step(self, x: RampState, u: TrafficInputs, h: float) -> RampState:  # noqa: ARG002
        """The exact motion over `h`."""
        moved = [self._ramp(x.s[i], x.v[i], self.v_final[i], self.a[i], h) for i in range(SLOTS)]
        return RampState(s=vector([s for s, _ in moved]), v=vector([v for _, v in moved]))

    @staticmethod
    def _ramp(s: float, v: float, v_final: float, a: float, h: float) -> tuple[float, float]:
        change = fmin(absolute(v_final - v), a * h) * sign(v_final - v)  # a_r t_r
        t_r = fmin(h, absolute(change) / (a + (a <= 0)))  # 0 / 1 where there is no ramp
        return s + v * h + change * (h - t_r / 2), v + change
