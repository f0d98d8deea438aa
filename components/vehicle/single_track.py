"""What all single-track (bicycle) models share; each block adds how the tyres' forces depend on their slip."""

from __future__ import annotations

from abc import abstractmethod
from typing import Final

from components.interfaces.block import Continuous
from components.interfaces.buses import Actuation, Motion, Tyre, VehicleState
from components.interfaces.frames import slip_angle, to_road
from components.interfaces.maths import absolute, cos, sin, sqrt
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.sockets import PlantInputs

V_LEAST: Final = 1.0
"""[m/s] Above this speed the slip angles are those of the paper; below it they go over into wheels that only roll."""


@record
class SingleTrackOutputs:
    """All buses a single-track model shows."""

    state: VehicleState
    tyre: Tyre
    motion: Motion


@record
class SingleTrack(Continuous[PlantInputs, VehicleState, SingleTrackOutputs]):
    """Equations of motion (1) and slip angles (3) of the paper, with two tyres per axle; `forces` gives (2).

    Reference point: centre of gravity.
    """

    m: float = quantity("kg", "mass", min=1)
    I_z: float = quantity("kg.m2", "yaw inertia", min=1)
    l_f: float = quantity("m", "distance from the centre of gravity to the front axle", min=0.1)
    l_r: float = quantity("m", "distance from the centre of gravity to the rear axle", min=0.1)
    C_alpha_f: float = quantity("N/rad", "cornering stiffness of one front tyre", min=0)
    C_alpha_r: float = quantity("N/rad", "cornering stiffness of one rear tyre", min=0)
    R_w: float = quantity("m", "wheel radius", min=0.01)
    mu: float = quantity("1", "friction coefficient of the road", min=0.01, max=2)
    g: float = quantity("m/s2", "gravity", min=0.1)
    x_start: float = quantity("m", "initial position along the road")
    y_start: float = quantity("m", "initial position across the road")
    psi_start: float = quantity("rad", "initial yaw angle")
    v_x_start: float = quantity("m/s", "initial longitudinal speed", min=0)
    v_y_start: float = quantity("m/s", "initial lateral speed")
    r_start: float = quantity("rad/s", "initial yaw rate")

    def start(self) -> VehicleState:
        """The initial state given by the parameters."""
        return VehicleState(
            x=self.x_start,
            y=self.y_start,
            psi=self.psi_start,
            v_x=self.v_x_start,
            v_y=self.v_y_start,
            r=self.r_start,
        )

    def slip(self, x: VehicleState, u: Actuation) -> tuple[float, float]:
        """Slip angles of the front and rear tyres (3); they vanish with the speed below `V_LEAST`."""
        alpha_f = slip_angle(x.v_x, x.v_y + self.l_f * x.r, u.delta_f, V_LEAST)  # (3)
        alpha_r = slip_angle(x.v_x, x.v_y - self.l_r * x.r, 0.0, V_LEAST)  # (3)
        return alpha_f, alpha_r

    def loads(self) -> tuple[float, float]:
        """Static loads of one front and one rear tyre [N]."""
        F_zf = self.m * self.g * self.l_r / (self.l_f + self.l_r) / 2
        F_zr = self.m * self.g * self.l_f / (self.l_f + self.l_r) / 2
        return F_zf, F_zr

    @abstractmethod
    def forces(self, x: VehicleState, u: Actuation) -> tuple[float, float]:
        """Lateral forces of one front and one rear tyre (2)."""

    def derivative(self, x: VehicleState, u: PlantInputs) -> VehicleState:
        """The equations of motion (1)."""
        delta_f, T_r = u.actuation.delta_f, u.actuation.T_r
        F_cf, F_cr = self.forces(x, u.actuation)
        x_dot, y_dot = to_road(x.psi, x.v_x, x.v_y)  # (1)
        return VehicleState(
            x=x_dot,
            y=y_dot,
            psi=x.r,
            v_x=x.r * x.v_y - 2 / self.m * (F_cf * sin(delta_f) - T_r / self.R_w),  # (1)
            v_y=-x.r * x.v_x + 2 / self.m * (F_cf * cos(delta_f) + F_cr),  # (1)
            r=2 / self.I_z * (self.l_f * F_cf - self.l_r * F_cr),  # (1)
        )

    def output(self, x: VehicleState, u: PlantInputs) -> SingleTrackOutputs:
        """The state, and the slips, forces and accelerations with the actuation of this instant."""
        alpha_f, alpha_r = self.slip(x, u.actuation)
        F_cf, F_cr = self.forces(x, u.actuation)
        dx = self.derivative(x, u)
        F_zf, F_zr = self.loads()
        F_xr = u.actuation.T_r / self.R_w
        return SingleTrackOutputs(
            state=x,
            tyre=Tyre(
                alpha_f=alpha_f,
                alpha_r=alpha_r,
                F_cf=F_cf,
                F_cr=F_cr,
                mu_f=absolute(F_cf) / (self.mu * F_zf),
                mu_r=sqrt(F_cr * F_cr + F_xr * F_xr) / (self.mu * F_zr),
            ),
            motion=Motion(a_x=dx.v_x - x.r * x.v_y, a_y=dx.v_y + x.r * x.v_x, r_dot=dx.r),
        )
