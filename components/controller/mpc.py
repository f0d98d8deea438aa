"""The paper's controller: path planning and tracking in one optimisation (Algorithm 1)."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, final

from typing_extensions import override

from components.controller.algorithms import active_set
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.problems.ocp import Horizon, Model, Problem, Weights
from components.controller.reference import Guidance, Reference
from components.controller.solving import ITERATIONS, N_P, TOLERANCE, Decision, accepted, shifted
from components.interfaces.block import Sampled, block
from components.interfaces.buses import Actuation, Plan, Solver, SolverStatus, VehicleState, Waypoints
from components.interfaces.maths import Array, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import part, record
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged


@record
class MpcState:
    """What the controller remembers: the manoeuvre, and its plan as a start for the next solve."""

    manoeuvre: Manoeuvre
    z: Array = quantity("1", "scaled decision of the last solve", shape=(2 * N_P,))


@record
class MpcOutputs:
    """All buses the controller shows."""

    actuation: Actuation
    path: Waypoints
    plan: Plan
    solver: Solver


@record
class IntegratedMpc(Guidance, Model, Sampled[ControllerInputs, MpcState, MpcOutputs]):
    """Integrated path planning and tracking by nonlinear model prediction, the paper's Algorithm 1, whatever solves it.

    At every sample: when to change lanes (`planner`), the Dubins path with its waypoints (`dubins`), the corridor
    (`corridor`), then the optimal control problem (`ocp`), solved from the previous plan.
    The first decision is applied. Where a solve does not end in numbers the previous plan is followed one step
    further (`solver.status` = fallback). Decisions are clipped to their bounds in any case.

    The desired point X_d(k+i) is `v_d i dt` along the path from the projection of the ego on it (RESOLUTIONS 13).
    Feedthrough: all inputs to all outputs. Valid for v_x > 1 m/s.
    """

    staged: ClassVar[bool] = True
    N_p: ClassVar[int] = N_P
    kkt_converged: ClassVar[float] = TOLERANCE
    """Residual of the optimality conditions up to which `solver.status` is converged."""

    a_1: float = quantity("1/m2", "weight of the distance to the path", min=0)
    b_1: float = quantity("m4", "weight of the upper boundary", min=0)
    b_2: float = quantity("m4", "weight of the lower boundary", min=0)
    b_3: float = quantity("s4/rad2", "weight of the yaw acceleration", min=0)
    delta_max: float = quantity("rad", "largest front road-wheel angle", min=0.001, max=1.5)
    T_dmax: float = quantity("N.m", "largest driving torque on one rear wheel", min=0)
    T_bmax: float = quantity("N.m", "largest braking torque on one rear wheel", min=0)
    delta_scale: float = quantity("rad", "unit of the angles in the optimisation", min=1e-6)
    T_scale: float = quantity("N.m", "unit of the torques in the optimisation", min=1e-6)

    def start(self) -> MpcState:
        """No manoeuvre, wheels straight."""
        return MpcState(manoeuvre=no_manoeuvre(), z=vector([0.0] * (2 * N_P)))

    def sample(self, x: MpcState, u: ControllerInputs) -> tuple[MpcState, MpcOutputs]:
        """One pass of Algorithm 1."""
        dims = self.dimensions()
        reference = staged(Mpc.reference, Reference, dims, self, x.manoeuvre, u)
        problem = self.problem(u.ego, reference.horizon)
        guess = shifted(x.z)
        decision = accepted(bounds(problem), self.solve(problem, guess), guess, self.kkt_converged)
        outputs = staged(_outputs, MpcOutputs, dims, problem, reference, decision)
        return MpcState(manoeuvre=reference.manoeuvre, z=decision.z), outputs

    @abstractmethod
    def solve(self, problem: Problem, guess: Array) -> active_set.Solution:
        """The minimiser of ``problem.cost`` within its bounds, searched from `guess`."""

    def problem(self, ego: VehicleState, horizon: Horizon) -> Problem:
        """The optimal control problem for this vehicle."""
        return Problem(
            model=part(Model, self),
            weights=part(Weights, self),
            horizon=horizon,
            start=ego,
            dt=self.dt,
            delta_max=self.delta_max,
            T_dmax=self.T_dmax,
            T_bmax=self.T_bmax,
            delta_scale=self.delta_scale,
            T_scale=self.T_scale,
        )


@final
@block(CONTROLLER)
class Mpc(IntegratedMpc):
    """Integrated path planning and tracking by nonlinear model prediction (the paper's Algorithm 1), active-set method.

    See `IntegratedMpc`; the problem is solved by `active_set`, as plain C in the FMU.
    """

    @override
    def solve(self, problem: Problem, guess: Array) -> active_set.Solution:
        """An active-set Newton method."""
        dims = self.dimensions()
        return active_set.minimise(
            Problem.cost, bounds, problem, dims, guess, iterations=ITERATIONS, tolerance=TOLERANCE
        )


def bounds(problem: Problem) -> tuple[Array, Array]:
    """Lower and upper bounds of the decision."""
    return problem.bounds(N_P)


def _outputs(problem: Problem, reference: Reference, decision: Decision) -> MpcOutputs:
    states = problem.prediction(decision.z)
    delta_f, T_r = problem.controls(decision.z)[0]
    horizon = reference.horizon
    lost = decision.solver.status == float(SolverStatus.fallback)  # there may be no prediction: show the path
    return MpcOutputs(
        actuation=Actuation(delta_f=delta_f, T_r=T_r),
        path=reference.path,
        plan=Plan(
            x=vector([where(lost, horizon.x_d[i], s.x) for i, s in enumerate(states)]),
            y=vector([where(lost, horizon.y_d[i], s.y) for i, s in enumerate(states)]),
            x_d=horizon.x_d,
            y_d=horizon.y_d,
            y_upper=horizon.y_upper,
            y_lower=horizon.y_lower,
        ),
        solver=decision.solver,
    )
