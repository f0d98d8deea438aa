"""The empty plug of the plant socket."""

from __future__ import annotations

from typing import final

from components.interfaces.block import Block, NoState, block
from components.interfaces.buses import VehicleState
from components.interfaces.quantity import quantity
from components.interfaces.sockets import PLANT, PlantInputs, PlantOutputs


@final
@block(PLANT)
class Stationary(Block[PlantInputs, NoState, PlantOutputs]):
    """Vehicle that stands still, whatever the actuation."""

    x_start: float = quantity("m", "position along the road")
    y_start: float = quantity("m", "position across the road")
    psi_start: float = quantity("rad", "yaw angle")

    def start(self) -> NoState:
        """Nothing to remember."""
        return NoState()

    def output(self, x: NoState, u: PlantInputs) -> PlantOutputs:  # noqa: ARG002 - it stands still
        """The given pose, without motion."""
        state = VehicleState(x=self.x_start, y=self.y_start, psi=self.psi_start, v_x=0.0, v_y=0.0, r=0.0)
        return PlantOutputs(state=state)

    def step(self, x: NoState, u: PlantInputs, h: float) -> NoState:  # noqa: ARG002
        """Nothing changes."""
        return x
