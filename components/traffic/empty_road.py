"""The empty plug of the traffic socket."""

from __future__ import annotations

from typing import final

from components.interfaces.block import Block, NoState, block
from components.interfaces.buses import SLOTS, ObstacleList
from components.interfaces.maths import vector
from components.interfaces.sockets import TRAFFIC, TrafficInputs, TrafficOutputs


@final
@block(TRAFFIC)
class EmptyRoad(Block[TrafficInputs, NoState, TrafficOutputs]):
    """Road without any obstacle: all slots are invalid."""

    def start(self) -> NoState:
        """Nothing to remember."""
        return NoState()

    def output(self, x: NoState, u: TrafficInputs) -> TrafficOutputs:  # noqa: ARG002 - the road stays empty
        """Eight empty slots."""
        none = vector([0.0] * SLOTS)
        return TrafficOutputs(
            obstacles=ObstacleList(valid=none, id=none, x=none, y=none, psi=none, v=none, length=none, width=none)
        )

    def step(self, x: NoState, u: TrafficInputs, h: float) -> NoState:  # noqa: ARG002
        """Nothing changes."""
        return x
