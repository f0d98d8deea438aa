"""A baseline: the Dubins path fixed in advance, tracked by the Stanley steering law."""

from __future__ import annotations

from typing import final

from components.controller.planner import no_manoeuvre
from components.controller.tracking import TrackerOutputs, TrackerState, Tracking, deviation, nearest
from components.interfaces.block import Sampled, block
from components.interfaces.buses import VehicleState
from components.interfaces.frames import to_road
from components.interfaces.maths import atan2
from components.interfaces.quantity import quantity
from components.interfaces.sockets import CONTROLLER, ControllerInputs


@final
@block(CONTROLLER)
class Stanley(Tracking, Sampled[ControllerInputs, TrackerState, TrackerOutputs]):
    """Two-level baseline: Dubins path fixed in advance, Stanley steering law, PI on speed.

    With the lateral error e_f and the heading error psi_e at the point of the path nearest to the front axle

        delta_f = -psi_e - atan(k e_f / v_x).

    The path is that of `lqr`. In a sample whose inputs are not numbers the wheels are straight and the torque
    is zero.
    Feedthrough: all inputs to all outputs.
    Reference: G. Hoffmann, C. Tomlin, M. Montemerlo, S. Thrun, American Control Conference (2007).
    """

    l_f: float = quantity("m", "distance from the centre of gravity to the front axle", min=0.1)
    k: float = quantity("1/s", "gain of the lateral error of the front axle", min=0)

    def start(self) -> TrackerState:
        """No manoeuvre."""
        return TrackerState(manoeuvre=no_manoeuvre(), integral=0.0)

    def sample(self, x: TrackerState, u: ControllerInputs) -> tuple[TrackerState, TrackerOutputs]:
        """Path, errors, steering and torque."""
        manoeuvre = self.fixed(x.manoeuvre, u)
        path = self.path(manoeuvre, u.ego)
        front = _ahead(u.ego, self.l_f)
        at = deviation(nearest(path, front.x, front.y), front)
        delta_f = -at.psi_e - atan2(self.k * at.e, front.v_x)
        actuation, integral = self.actuation(delta_f, manoeuvre.v_d, x.integral, u.ego)
        return (
            TrackerState(manoeuvre=manoeuvre, integral=integral),
            TrackerOutputs(actuation=actuation, path=path.waypoints),
        )


def _ahead(ego: VehicleState, distance: float) -> VehicleState:
    """The state of the point of the vehicle `distance` ahead of its centre of gravity."""
    dx, dy = to_road(ego.psi, distance, 0.0)
    return VehicleState(x=ego.x + dx, y=ego.y + dy, psi=ego.psi, v_x=ego.v_x, v_y=ego.v_y + ego.r * distance, r=ego.r)
