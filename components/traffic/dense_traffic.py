"""Traffic with more obstacles than the bus has slots: the ego vehicle is shown those that are nearest to it."""

from __future__ import annotations

from typing import ClassVar, final

from components.interfaces.block import Block, block
from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from components.interfaces.maths import Array, fmin, vector, where
from components.interfaces.sockets import TRAFFIC, TrafficInputs, TrafficOutputs
from components.traffic.ramps import Ramps, RampState

_FAR = 1e300
"""[m2] The square of a distance that is none: of a place that holds no obstacle, or of one without a known position."""


@final
@block(TRAFFIC)
class DenseTraffic(Ramps, Block[TrafficInputs, RampState, TrafficOutputs]):
    """Up to 32 obstacles that ramp from a start speed to a final speed; the bus shows the nearest to the ego first.

    They move as those of `ramp_traffic` do and do not react to `ego`, of which only the position counts. At each
    instant the slots hold the obstacles with the least distances ``d^2 = (x_o - x)^2 + (y_o - y)^2`` between centres,
    nearest first, of equally distant ones the first in the list; places without an obstacle come last. The `id` of an
    obstacle is its place in the list, counted from 1: a slot may change its obstacle from one instant to the next, an
    `id` never does. Who is farther away than eight others is not seen by anybody.
    Feedthrough: `ego.x` and `ego.y` to all signals.
    """

    N_o: ClassVar[int] = 32
    if_longer: ClassVar[str] = "No block holds more obstacles: leave out those that the ego never gets near to."

    def output(self, x: RampState, u: TrafficInputs) -> TrafficOutputs:
        """The nearest obstacles, as they are now."""
        x_o, y_o = self.places(x)
        rank = self._ranks(x_o, y_o, u.ego)

        def nearest(values: Array) -> Array:
            return vector([_of_rank(k, rank, values) for k in range(SLOTS)])

        return TrafficOutputs(
            obstacles=ObstacleList(
                valid=nearest(self.valid),
                id=nearest(vector([float(i + 1) for i in range(self.N_o)])),
                x=nearest(x_o),
                y=nearest(y_o),
                psi=nearest(self.psi_start),
                v=nearest(x.v),
                length=nearest(self.length),
                width=nearest(self.width),
            )
        )

    def _ranks(self, x_o: Array, y_o: Array, ego: VehicleState) -> list[float]:
        """How many obstacles come before each one; every number from 0 to N_o - 1 once."""
        squares = ((x_o[i] - ego.x) * (x_o[i] - ego.x) + (y_o[i] - ego.y) * (y_o[i] - ego.y) for i in range(self.N_o))
        # fmin also replaces what is not a number
        d = [where(self.valid[i], fmin(square, _FAR), 2 * _FAR) for i, square in enumerate(squares)]
        return [
            sum(where(d[j] <= d[i] if j < i else d[j] < d[i], 1.0, 0.0) for j in range(self.N_o) if j != i)
            for i in range(self.N_o)
        ]


def _of_rank(k: int, rank: list[float], values: Array) -> float:
    """The value of the obstacle that has `k` others before it."""
    return sum(where(r == k, values[i], 0.0) for i, r in enumerate(rank))
