"""A baseline: a model predictive planner that knows a point mass only, and a regulator that tracks what it plans."""

from __future__ import annotations

from typing import ClassVar, final

from components.controller.algorithms import active_set
from components.controller.lqr_tracking import Gain, LqrTracking
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.problems.ocp import Weights
from components.controller.problems.point_mass import PlanningProblem, PointMass
from components.controller.reference import Guidance, PathReference
from components.controller.solving import KKT_TOLERANCE, N_P, Decision, PredictiveOutputs, decided, shifted
from components.controller.tracking import Target, deviation
from components.interfaces.block import Sampled, block
from components.interfaces.buses import VehicleState
from components.interfaces.frames import to_road
from components.interfaces.maths import Array, atan2, both, cos, fmax, fmin, is_number, negate, sin, sqrt, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import combine, leaves, record
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged

_ITERATIONS = 20
"""Iterations per solve at most; most solves need four, the last of which finds that it has converged."""

_LARGEST = 1e9
"""A new state with a larger number has diverged, and the previous one is kept."""

_SLOWEST = 1.0
"""[m/s] Below this the curvature of the plan is taken as at this speed."""


@record
class TwoLevelState:
    """What the controller remembers: the manoeuvre, the planned point, the last solve, and the tracker's state."""

    manoeuvre: Manoeuvre
    point: PointMass
    K: Gain
    begun: float = quantity("1", "1 once a first sample has set the planned point, else 0")
    integral: float = quantity("N.m", "integral part of the speed controller")
    z: Array = quantity("1", "scaled decision of the last solve", shape=(2 * N_P,))


@record
class _Sample:
    x: TwoLevelState
    y: PredictiveOutputs


@record
class _Given:
    reference: PathReference
    problem: PlanningProblem


@final
@block(CONTROLLER)
class TwoLevelMp(LqrTracking, Guidance, Sampled[ControllerInputs, TwoLevelState, PredictiveOutputs]):
    """Two-level baseline: point-mass MP planner, LQR as tracker, PI on speed.

    Upper level: path, corridor and horizon are those of `mpc`, anew at every sample; the plan minimises the same
    distances (`point_mass`), without a yaw term because a point mass has no yaw. It goes on from the planned point of
    the sample before, moved along its own direction to where the vehicle is beside it: the plan follows the progress of
    the vehicle, but not its lateral error. Lower level: `lqr_tracking` on the errors from the planned point, with the
    direction and the curvature of the planned motion; PI on its speed.

    Where a solve gives no finite numbers the previous plan is followed one sample further.
    The gain is computed at the start: other weights during a run take effect at the next start.
    Feedthrough: all inputs to all outputs.
    """

    staged: ClassVar[bool] = True
    N_p: ClassVar[int] = N_P

    a_1: float = quantity("1/m2", "weight of the distance to the path", min=0)
    b_1: float = quantity("m4", "weight of the upper boundary", min=0)
    b_2: float = quantity("m4", "weight of the lower boundary", min=0)

    def start(self) -> TwoLevelState:
        """No manoeuvre, no plan, and the gain for these weights."""
        return TwoLevelState(
            manoeuvre=no_manoeuvre(),
            point=PointMass(x=0.0, y=0.0, v_x=0.0, v_y=0.0),
            K=self.gain(),
            begun=0.0,
            integral=0.0,
            z=vector([0.0] * (2 * N_P)),
        )

    def sample(self, x: TwoLevelState, u: ControllerInputs) -> tuple[TwoLevelState, PredictiveOutputs]:
        """Plan, then track."""
        dims = self.dimensions()
        given = staged(_given, _Given, dims, self, x, u)
        guess = x.z + (shifted(x.z) - x.z) * fmin(self.T_s / self.dt, 1.0)  # a sample is a share of a prediction step
        solution = active_set.minimise(given.problem, dims, guess, iterations=_ITERATIONS, tolerance=KKT_TOLERANCE)
        decision = decided(solution, guess, given.problem.bounds())
        now = staged(_tracked, _Sample, dims, self, x, u, given, decision)
        return now.x, now.y


def _given(self: TwoLevelMp, x: TwoLevelState, u: ControllerInputs) -> _Given:
    """The reference, and the problem that begins at the planned point of this instant."""
    reference = self.reference(x.manoeuvre, u)
    problem = PlanningProblem(
        weights=Weights(a_1=self.a_1, b_1=self.b_1, b_2=self.b_2, b_3=0.0),
        horizon=reference.horizon,
        start=_point(x, u.ego),
        dt=self.dt,
        a_max=self.mu * self.g,
    )
    return _Given(reference=reference, problem=problem)


def _point(x: TwoLevelState, ego: VehicleState) -> PointMass:
    """The planned point beside the vehicle; at first, the vehicle itself."""
    v_x, v_y = to_road(ego.psi, ego.v_x, ego.v_y)
    first = PointMass(x=ego.x, y=ego.y, v_x=v_x, v_y=v_y)
    psi = atan2(x.point.v_y, x.point.v_x)
    lag = (ego.x - x.point.x) * cos(psi) + (ego.y - x.point.y) * sin(psi)
    along = where(is_number(lag, limit=_LARGEST), lag, 0.0)
    later = PointMass(x=x.point.x + along * cos(psi), y=x.point.y + along * sin(psi), v_x=x.point.v_x, v_y=x.point.v_y)

    def chosen(new: float, old: float) -> float:
        return where(x.begun > 0, old, new)

    return combine(chosen, first, later)


def _tracked(self: TwoLevelMp, x: TwoLevelState, u: ControllerInputs, given: _Given, decision: Decision) -> _Sample:
    """Track the planned point, and move it on."""
    problem = given.problem
    point = problem.start
    a_x, a_y = problem.accelerations(decision.z)[0]
    v = fmax(sqrt(point.v_x * point.v_x + point.v_y * point.v_y), _SLOWEST)
    kappa = (point.v_x * a_y - point.v_y * a_x) / (v * v * v)
    target = Target(x=point.x, y=point.y, psi=atan2(point.v_y, point.v_x), kappa=kappa)
    delta_f = self.steering(x.K, deviation(target, u.ego), kappa, u.ego.v_x)
    later = point.moved(a_x, a_y, self.T_s)
    v_d = sqrt(later.v_x * later.v_x + later.v_y * later.v_y)
    actuation, integral = self.actuation(delta_f, v_d, x.integral, u.ego)

    known = is_number(*leaves(later), limit=_LARGEST)

    def kept(new: float, old: float) -> float:
        return where(known, new, old)

    states = problem.prediction(decision.z)
    return _Sample(
        x=TwoLevelState(
            manoeuvre=given.reference.manoeuvre,
            point=combine(kept, later, x.point),
            K=x.K,
            begun=where(both(negate(x.begun > 0), negate(known)), 0.0, 1.0),
            integral=integral,
            z=decision.z,
        ),
        y=PredictiveOutputs(
            actuation=actuation,
            path=given.reference.path,
            plan=given.reference.horizon.plan(x=vector([s.x for s in states]), y=vector([s.y for s in states])),
            solver=decision.solver,
        ),
    )
