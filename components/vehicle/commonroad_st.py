"""The single-track model of commonroad-vehicle-models."""
# pyright: basic
# The package carries no types.

from __future__ import annotations

from functools import cache
from typing import final

from components.interfaces.block import Block, block
from components.interfaces.buses import Motion, VehicleState
from components.interfaces.maths import cos, sin
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.sockets import PLANT, PlantInputs
from components.vehicle.commonroad import CommonRoadOutputs, CommonRoadVehicle, Dynamics


@record
class StState:
    """The state as the package orders it."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    delta: float = quantity("rad", "steering angle of the front wheels")
    v: float = quantity("m/s", "speed", min=0)
    psi: float = quantity("rad", "yaw angle")
    r: float = quantity("rad/s", "yaw rate")
    beta: float = quantity("rad", "slip angle at the centre of gravity")


@final
@block(PLANT)
class CommonroadSt(CommonRoadVehicle[StState], Block[PlantInputs, StState, CommonRoadOutputs]):
    """Single-track vehicle of commonroad-vehicle-models, with load transfer by acceleration; linear tyres.

    M. Althoff, G. Wuersching: CommonRoad: Vehicle Models, 2020, chapter 7; below 0.1 m/s the kinematic model.
    Our actuation and the stop: see `commonroad`. Needs the extra `commonroad`.

    Reference point: centre of gravity. Feedthrough: `actuation` to `motion`, none to `state`.
    """

    @staticmethod
    @cache
    def dynamics() -> Dynamics:
        """`vehicle_dynamics_st`."""
        from vehiclemodels.init_st import init_st  # noqa: PLC0415 - an extra
        from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st  # noqa: PLC0415

        return Dynamics(
            state=StState,
            start=lambda core, _: init_st(core),
            slope=vehicle_dynamics_st,
            speed="v",
            moving=("r", "beta"),
        )

    def shown(self, x: StState) -> VehicleState:
        """Speed and slip angle as components in the body frame."""
        return VehicleState(x=x.x, y=x.y, psi=x.psi, v_x=x.v * cos(x.beta), v_y=x.v * sin(x.beta), r=x.r)

    def moved(self, x: StState, dx: StState) -> Motion:
        """Along and across the speed, which turns with r + beta_dot; resolved in the body frame."""
        across = x.v * (x.r + dx.beta)
        return Motion(
            a_x=dx.v * cos(x.beta) - across * sin(x.beta),
            a_y=dx.v * sin(x.beta) + across * cos(x.beta),
            r_dot=dx.r,
        )
