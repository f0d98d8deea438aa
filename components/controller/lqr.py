"""A baseline: the Dubins path fixed in advance, tracked by a linear-quadratic regulator."""

from __future__ import annotations

from typing import ClassVar, final

from components.controller.lqr_tracking import Gain, LqrTracking
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.tracking import TrackerOutputs, deviation, nearest
from components.interfaces.block import Sampled, block
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged


@record
class LqrState:
    """What the controller remembers: the path, the integral part of the speed controller, and its gain."""

    manoeuvre: Manoeuvre
    K: Gain
    integral: float = quantity("N.m", "integral part of the speed controller")


@record
class _Sample:
    x: LqrState
    y: TrackerOutputs


@final
@block(CONTROLLER)
class Lqr(LqrTracking, Sampled[ControllerInputs, LqrState, TrackerOutputs]):
    """Two-level baseline: Dubins path fixed in advance, LQR with curvature feedforward, PI on speed.

    The planner of `mpc` decides on the path at the first sample at which a lane change is needed and possible; from
    then on the path stays, whatever the traffic does. Lateral and heading error are those of the centre of gravity at
    the nearest point of the path (`lqr_tracking`). In a sample whose inputs are not numbers the wheels
    are straight and the torque is zero.

    The gain is computed at the start: other weights during a run take effect at the next start.
    Feedthrough: all inputs to all outputs.
    """

    staged: ClassVar[bool] = True

    def start(self) -> LqrState:
        """No manoeuvre, and the gain for these weights."""
        return LqrState(manoeuvre=no_manoeuvre(), K=self.gain(), integral=0.0)

    def sample(self, x: LqrState, u: ControllerInputs) -> tuple[LqrState, TrackerOutputs]:
        """Path, errors, steering and torque."""
        now = staged(_sample, _Sample, self.dimensions(), self, x, u)
        return now.x, now.y


def _sample(self: Lqr, x: LqrState, u: ControllerInputs) -> _Sample:
    manoeuvre = self.fixed(x.manoeuvre, u)
    path = self.path(manoeuvre, u.ego)
    target = nearest(path, u.ego.x, u.ego.y)
    delta_f = self.steering(x.K, deviation(target, u.ego), target.kappa, u.ego.v_x)
    actuation, integral = self.actuation(delta_f, manoeuvre.v_d, x.integral, u.ego)
    return _Sample(
        x=LqrState(manoeuvre=manoeuvre, K=x.K, integral=integral),
        y=TrackerOutputs(actuation=actuation, path=path.waypoints),
    )
