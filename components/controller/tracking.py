"""What controllers that track a given path share: the errors from it, the path itself, and the speed control."""

from __future__ import annotations

from components.controller import dubins
from components.controller.planner import Manoeuvre
from components.controller.reference import PathPlanning
from components.interfaces.buses import Actuation, VehicleState, Waypoints
from components.interfaces.maths import atan2, clip, cos, is_number, sin, where
from components.interfaces.quantity import quantity
from components.interfaces.record import combine, record
from components.interfaces.sockets import ControllerInputs


@record
class TrackerState:
    """What a tracking controller remembers: the path, and the integral of the speed control."""

    manoeuvre: Manoeuvre
    integral: float = quantity("N.m", "integral part of the speed controller")


@record
class TrackerOutputs:
    """All buses a tracking controller shows."""

    actuation: Actuation
    path: Waypoints


@record
class Target:
    """Where the vehicle should be: a point of the path, its direction and its curvature."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    psi: float = quantity("rad", "direction of travel")
    kappa: float = quantity("1/m", "curvature, positive to the left")


@record
class Deviation:
    """Where the vehicle is, seen from its target."""

    e: float = quantity("m", "lateral error, positive to the left")
    e_dot: float = quantity("m/s", "rate of the lateral error")
    psi_e: float = quantity("rad", "heading error, positive to the left")
    psi_e_dot: float = quantity("rad/s", "rate of the heading error")


def nearest(path: dubins.Path, x: float, y: float) -> Target:
    """The point of the path nearest to (x, y) [m]."""
    s = path.project(x, y)
    x_s, y_s = path.point(s)
    psi, kappa = path.direction(s)
    return Target(x=x_s, y=y_s, psi=psi, kappa=kappa)


def deviation(target: Target, ego: VehicleState) -> Deviation:
    """The errors of a vehicle at (x, y, psi) that moves with (v_x, v_y, r); ``psi_e_dot = r - kappa v_x``."""
    turned = ego.psi - target.psi
    psi_e = atan2(sin(turned), cos(turned))
    return Deviation(
        e=(ego.y - target.y) * cos(target.psi) - (ego.x - target.x) * sin(target.psi),
        e_dot=ego.v_x * sin(psi_e) + ego.v_y * cos(psi_e),
        psi_e=psi_e,
        psi_e_dot=ego.r - target.kappa * ego.v_x,
    )


def bounded(value: float, low: float, high: float) -> float:
    """`value`, kept inside its bounds; 0 where it is not a number."""
    return where(is_number(value), clip(value, low, high), 0.0)


@record
class Tracking(PathPlanning):
    """A path fixed in advance, the bounds of the actuation, and a speed controller.

    ``T_r = K_p (v_d - v_x) + integral``; the integral is held while it would drive T_r further beyond a bound
    (anti-windup).
    """

    T_s: float = quantity("s", "sampling time that the gains are meant for: the macro step", min=0.001, max=1)
    K_p: float = quantity("N.s", "proportional gain of the speed controller", min=0)
    K_i: float = quantity("N", "integral gain of the speed controller", min=0)
    delta_max: float = quantity("rad", "largest front road-wheel angle", min=0.001, max=1.5)
    T_dmax: float = quantity("N.m", "largest driving torque on one rear wheel", min=0)
    T_bmax: float = quantity("N.m", "largest braking torque on one rear wheel", min=0)

    def fixed(self, before: Manoeuvre, u: ControllerInputs) -> Manoeuvre:
        """The first manoeuvre that is planned; every later sample keeps it."""

        def kept(old: float, new: float) -> float:
            return where(before.planned > 0, old, new)

        return combine(kept, before, self.manoeuvre(before, u))

    def actuation(self, delta_f: float, v_d: float, integral: float, ego: VehicleState) -> tuple[Actuation, float]:
        """The bounded actuation, with the torque of the speed controller.

        Args:
            delta_f: The steering angle that is asked for [rad].
            v_d: The desired speed [m/s].
            integral: The integral part of the torque [N.m].
            ego: The state of the vehicle.

        Returns:
            The actuation, and the next integral [N.m].
        """
        slow = v_d - ego.v_x
        wanted = self.K_p * slow + integral
        T_r = bounded(wanted, -self.T_bmax, self.T_dmax)
        grows = (wanted - T_r) * slow <= 0  # false for NaN, which must not enter the state
        summed = where(grows, integral + self.K_i * slow * self.T_s, integral)
        return Actuation(delta_f=bounded(delta_f, -self.delta_max, self.delta_max), T_r=T_r), summed
