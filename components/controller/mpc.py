"""The paper's controller: path planning and tracking in one optimisation (Algorithm 1)."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, final

from typing_extensions import override

from components.controller.algorithms import active_set
from components.controller.algorithms.bounded import Solution
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.problems.ocp import Horizon, OptimalControlProblem, PredictedVehicle, Weights
from components.controller.reference import Guidance, PathReference
from components.controller.solving import (
    KKT_TOLERANCE,
    N_P,
    Decision,
    PredictiveOutputs,
    decided,
    shifted,
    shown_plan,
)
from components.interfaces.block import Sampled, block
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.maths import Array, vector
from components.interfaces.quantity import quantity
from components.interfaces.record import part, record
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged

NEWTON_ITERATIONS = 10
"""Iterations per solve at most; most solves need four, the last of which finds that it has converged."""


@record
class MpcState:
    """What the controller remembers: the manoeuvre, and its plan, from which the next solve starts."""

    manoeuvre: Manoeuvre
    z: Array = quantity("1", "scaled decision of the last solve", shape=(2 * N_P,))


@record
class IntegratedMpc(Guidance, PredictedVehicle, Sampled[ControllerInputs, MpcState, PredictiveOutputs]):
    """Integrated path planning and tracking by nonlinear model prediction, the paper's Algorithm 1, whatever solves it.

    At every sample: when to change lanes (`planner`), the Dubins path with its waypoints (`dubins`), the corridor
    (`corridor`), then the optimal control problem (`ocp`), solved from the previous plan.
    The first decision is applied. Where a solve gives no finite numbers the previous plan is followed one step
    further (`solver.status` = fallback). Decisions are clipped to their bounds in any case.

    The desired point X_d(k+i) is `v_d i dt` along the path from the projection of the ego on it (RESOLUTIONS 13), or
    further where the vehicle cannot slow down so fast (`progress`).
    Feedthrough: all inputs to all outputs.
    """

    staged: ClassVar[bool] = True
    N_p: ClassVar[int] = N_P
    kkt_converged: ClassVar[float] = KKT_TOLERANCE
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

    def sample(self, x: MpcState, u: ControllerInputs) -> tuple[MpcState, PredictiveOutputs]:
        """One pass of Algorithm 1."""
        dims = self.dimensions()
        reference = staged(Guidance.reference, PathReference, dims, self, x.manoeuvre, u)
        problem = self.problem(u.ego, reference.horizon)
        guess = shifted(x.z)
        decision = decided(self.solve(problem, guess), guess, problem.bounds(), self.kkt_converged)
        outputs = staged(_outputs, PredictiveOutputs, dims, problem, reference, decision)
        return MpcState(manoeuvre=reference.manoeuvre, z=decision.z), outputs

    @abstractmethod
    def solve(self, problem: OptimalControlProblem, guess: Array) -> Solution:
        """The minimiser of ``problem.cost`` within its bounds, searched from `guess`."""

    def problem(self, ego: VehicleState, horizon: Horizon) -> OptimalControlProblem:
        """The optimal control problem for this vehicle."""
        return OptimalControlProblem(
            vehicle=part(PredictedVehicle, self),
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
    def solve(self, problem: OptimalControlProblem, guess: Array) -> Solution:
        """An active-set Newton method."""
        return active_set.minimise(
            problem, self.dimensions(), guess, iterations=NEWTON_ITERATIONS, tolerance=KKT_TOLERANCE
        )


def _outputs(problem: OptimalControlProblem, reference: PathReference, decision: Decision) -> PredictiveOutputs:
    delta_f, T_r = problem.controls(decision.z)[0]
    return PredictiveOutputs(
        actuation=Actuation(delta_f=delta_f, T_r=T_r),
        path=reference.path,
        plan=shown_plan(reference.horizon, problem.prediction(decision.z), decision.solver),
        solver=decision.solver,
    )
