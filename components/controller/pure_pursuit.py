"""A baseline: the Dubins path fixed in advance, tracked by pure pursuit."""

from __future__ import annotations

from typing import final

from components.controller.planner import no_manoeuvre
from components.controller.tracking import TrackerOutputs, TrackerState, Tracking
from components.interfaces.block import Sampled, block
from components.interfaces.frames import to_road
from components.interfaces.maths import atan2
from components.interfaces.quantity import quantity
from components.interfaces.sockets import CONTROLLER, ControllerInputs


@final
@block(CONTROLLER)
class PurePursuit(Tracking, Sampled[ControllerInputs, TrackerState, TrackerOutputs]):
    """Two-level baseline: Dubins path fixed in advance, pure pursuit, PI on speed.

    The point of the vehicle `l_back` behind its centre of gravity (textbooks take the rear axle, `l_back` = `l_r`) is
    led on a circle to the point of the path `l_ahead` further along it than the nearest one. Where that point is at
    the distance d, `left` to the left,

        kappa = 2 left / d^2,    delta_f = atan((l_f + l_r) kappa).

    The path is that of `lqr`. In a sample whose inputs are not numbers the wheels are straight and the torque
    is zero.
    Feedthrough: all inputs to all outputs.
    Reference: R. C. Coulter, Carnegie Mellon University, CMU-RI-TR-92-01 (1992).
    """

    l_f: float = quantity("m", "distance from the centre of gravity to the front axle", min=0.1)
    l_r: float = quantity("m", "distance from the centre of gravity to the rear axle", min=0.1)
    l_ahead: float = quantity("m", "look-ahead distance along the path", min=0.1)
    l_back: float = quantity("m", "how far behind the centre of gravity the point lies that is led to the path", min=0)

    def start(self) -> TrackerState:
        """No manoeuvre."""
        return TrackerState(manoeuvre=no_manoeuvre(), integral=0.0)

    def sample(self, x: TrackerState, u: ControllerInputs) -> tuple[TrackerState, TrackerOutputs]:
        """Path, the point to pursue, steering and torque."""
        manoeuvre = self.fixed(x.manoeuvre, u)
        path = self.path(manoeuvre, u.ego)
        dx, dy = to_road(u.ego.psi, -self.l_back, 0.0)
        x_b, y_b = u.ego.x + dx, u.ego.y + dy
        x_p, y_p = path.point(path.project(x_b, y_b) + self.l_ahead)
        _, left = to_road(-u.ego.psi, x_p - x_b, y_p - y_b)
        squared = (x_p - x_b) * (x_p - x_b) + (y_p - y_b) * (y_p - y_b)
        delta_f = atan2((self.l_f + self.l_r) * 2 * left, squared)
        actuation, integral = self.actuation(delta_f, manoeuvre.v_d, x.integral, u.ego)
        return (
            TrackerState(manoeuvre=manoeuvre, integral=integral),
            TrackerOutputs(actuation=actuation, path=path.waypoints),
        )
