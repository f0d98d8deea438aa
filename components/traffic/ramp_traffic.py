"""The paper's traffic: obstacles that each change to a speed of their own and keep it."""

from __future__ import annotations

from typing import ClassVar, final

from components.interfaces.block import Block, block
from components.interfaces.buses import SLOTS, ObstacleList
from components.interfaces.maths import vector
from components.interfaces.sockets import TRAFFIC, TrafficInputs, TrafficOutputs
from components.traffic.ramps import Ramps, RampState


@final
@block(TRAFFIC)
class RampTraffic(Ramps, Block[TrafficInputs, RampState, TrafficOutputs]):
    """Obstacles on straight lines that ramp from a start speed to a final speed.

    Each slot holds one obstacle; it changes its speed by `a` until it has reached `v_final` and keeps it
    (static: all speeds zero). The motion within a step is exact, whatever the step:
    with t_r = min(h, |v_final - v| / a) and the signed acceleration a_r,
    ``v' = v + a_r t_r`` and ``s' = s + v h + a_r t_r (h - t_r / 2)``.

    It does not react to `ego`. An obstacle with `a = 0` keeps its start speed. `dense_traffic` holds more obstacles.
    """

    N_o: ClassVar[int] = SLOTS
    if_longer: ClassVar[str] = (
        "The block `dense_traffic` holds 32 obstacles: `--traffic dense_traffic`, or `block` in the scenario."
    )

    def output(self, x: RampState, u: TrafficInputs) -> TrafficOutputs:  # noqa: ARG002 - it does not react to the ego vehicle
        """Where the obstacles are now."""
        x_o, y_o = self.places(x)
        return TrafficOutputs(
            obstacles=ObstacleList(
                valid=self.valid,
                id=vector([float(i + 1) for i in range(SLOTS)]),
                x=x_o,
                y=y_o,
                psi=self.psi_start,
                v=x.v,
                length=self.length,
                width=self.width,
            )
        )
