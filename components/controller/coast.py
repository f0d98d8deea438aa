"""The empty plug of the controller socket."""

from __future__ import annotations

from typing import final

from components.interfaces.block import NoState, Sampled, block
from components.interfaces.buses import Actuation
from components.interfaces.sockets import CONTROLLER, ControllerInputs, ControllerOutputs


@final
@block(CONTROLLER)
class Coast(Sampled[ControllerInputs, NoState, ControllerOutputs]):
    """Controller that lets the vehicle roll: wheels straight, no torque."""

    def start(self) -> NoState:
        """Nothing to remember."""
        return NoState()

    def sample(self, x: NoState, u: ControllerInputs) -> tuple[NoState, ControllerOutputs]:  # noqa: ARG002
        """No actuation."""
        return x, ControllerOutputs(actuation=Actuation(delta_f=0.0, T_r=0.0))
