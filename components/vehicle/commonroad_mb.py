"""The multi-body model of commonroad-vehicle-models."""
# pyright: basic
# The package carries no types.

from __future__ import annotations

from functools import cache
from typing import final

from components.interfaces.block import Block, block
from components.interfaces.buses import Motion, VehicleState
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.sockets import PLANT, PlantInputs
from components.vehicle.commonroad import CommonRoadOutputs, CommonRoadVehicle, Dynamics


@record
class MbState:
    """The state as the package orders it: body, front axle, rear axle, wheels."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    delta: float = quantity("rad", "steering angle of the front wheels")
    v_x: float = quantity("m/s", "longitudinal speed", min=0)
    psi: float = quantity("rad", "yaw angle")
    r: float = quantity("rad/s", "yaw rate")
    phi: float = quantity("rad", "roll angle")
    phi_dot: float = quantity("rad/s", "roll rate")
    theta: float = quantity("rad", "pitch angle")
    theta_dot: float = quantity("rad/s", "pitch rate")
    v_y: float = quantity("m/s", "lateral speed")
    z: float = quantity("m", "lowering of the body")
    v_z: float = quantity("m/s", "speed of the lowering")
    phi_f: float = quantity("rad", "roll angle of the front axle")
    phi_f_dot: float = quantity("rad/s", "roll rate of the front axle")
    v_y_f: float = quantity("m/s", "lateral speed of the front axle")
    z_f: float = quantity("m", "lowering of the front axle, which loads its tyres")
    v_z_f: float = quantity("m/s", "speed of this lowering")
    phi_r: float = quantity("rad", "roll angle of the rear axle")
    phi_r_dot: float = quantity("rad/s", "roll rate of the rear axle")
    v_y_r: float = quantity("m/s", "lateral speed of the rear axle")
    z_r: float = quantity("m", "lowering of the rear axle, which loads its tyres")
    v_z_r: float = quantity("m/s", "speed of this lowering")
    omega_fl: float = quantity("rad/s", "speed of the front wheel that the package calls left", min=0)
    omega_fr: float = quantity("rad/s", "speed of the front wheel that the package calls right", min=0)
    omega_rl: float = quantity("rad/s", "speed of the rear wheel that the package calls left", min=0)
    omega_rr: float = quantity("rad/s", "speed of the rear wheel that the package calls right", min=0)
    y_f: float = quantity("m", "lateral offset of the front axle")
    y_r: float = quantity("m", "lateral offset of the rear axle")


@final
@block(PLANT)
class CommonroadMb(CommonRoadVehicle[MbState], Block[PlantInputs, MbState, CommonRoadOutputs]):
    """Multi-body vehicle of commonroad-vehicle-models: suspension, four wheels, tyres after Pacejka, 29 states.

    M. Althoff, G. Wuersching: CommonRoad: Vehicle Models, 2020, chapter 9. Our actuation and the stop: see
    `commonroad`. Driving torque goes to the rear wheels, as ours does; braking torque is divided as the parameter set
    says (0.66 to the front). Needs the extra `commonroad`.

    The wheels that the package calls left are on the right after ISO 8855: in a left turn they run faster.

    Reference point: centre of gravity of the sprung mass. Feedthrough: `actuation` to `motion`, none to `state`.
    Valid for v_x > 1 m/s, and down to a stop.
    """

    @staticmethod
    @cache
    def dynamics() -> Dynamics:
        """`vehicle_dynamics_mb`."""
        from vehiclemodels.init_mb import init_mb  # noqa: PLC0415 - an extra
        from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb  # noqa: PLC0415

        wheels = ("omega_fl", "omega_fr", "omega_rl", "omega_rr")
        body = ("r", "phi_dot", "theta_dot", "v_y", "v_z")
        front, rear = ("phi_f_dot", "v_y_f", "v_z_f"), ("phi_r_dot", "v_y_r", "v_z_r")
        return Dynamics(
            state=MbState,
            start=init_mb,
            slope=vehicle_dynamics_mb,
            speed="v_x",
            moving=(*body, *front, *rear, *wheels),
            wheels=wheels,
        )

    def shown(self, x: MbState) -> VehicleState:
        """Of the sprung mass."""
        return VehicleState(x=x.x, y=x.y, psi=x.psi, v_x=x.v_x, v_y=x.v_y, r=x.r)

    def moved(self, x: MbState, dx: MbState) -> Motion:
        """Of the sprung mass."""
        return Motion(a_x=dx.v_x - x.r * x.v_y, a_y=dx.v_y + x.r * x.v_x, r_dot=dx.r)
