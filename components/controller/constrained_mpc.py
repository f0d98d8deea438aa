"""A controller that keeps the paper's idea, planning and tracking in one optimisation, and repairs what it breaks."""

from __future__ import annotations

from typing import ClassVar, final

from components.controller import dubins
from components.controller.algorithms import ilqr
from components.controller.algorithms.bounded import Solution
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.problems.constrained_ocp import (
    STAGES,
    ConstrainedProblem,
    ConstrainedSettings,
    StageInput,
    StageTarget,
    SteeredVehicle,
)
from components.controller.reference import Guidance, PathReference
from components.controller.solving import PredictiveOutputs, accepted, shown_plan
from components.interfaces.block import Sampled, block
from components.interfaces.buses import SLOTS, Actuation, ObstacleList
from components.interfaces.maths import Array, absolute, clip, fmax, fmin, sign, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import pack_all, part, record, size, unpack_all
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged

PREDICTION_STEPS = 20
"""Prediction steps, which cover 2 s at the sampling time."""

_ITERATIONS = 6
_CONVERGED = 1e-3
"""Largest relative decrease of the cost in the last iteration at which a solve has converged."""

_INPUTS = size(StageInput) * PREDICTION_STEPS
_TARGETS = size(StageTarget) * (PREDICTION_STEPS + 1)
_STATES = size(SteeredVehicle) * (PREDICTION_STEPS + 1)


@record
class ConstrainedMpcState:
    """What the controller remembers: the manoeuvre, its plan, and the angle it asked for last."""

    manoeuvre: Manoeuvre
    u: Array = quantity("1", "inputs of the last plan: rate and torque, step by step", shape=(_INPUTS,))
    delta_f: float = quantity("rad", "last steering angle")


@record
class _Task:
    """What this sample asks for, and where the search for it begins."""

    reference: PathReference
    now: SteeredVehicle
    targets: Array = quantity("1", "targets of the stages, step by step", shape=(_TARGETS,))
    guess: Array = quantity("1", "inputs: rate and torque, step by step", shape=(_INPUTS,))


@record
class _Found:
    """The trajectory that the search found."""

    u: Array = quantity("1", "inputs: rate and torque, step by step", shape=(_INPUTS,))
    x: Array = quantity("1", "predicted states, step by step", shape=(_STATES,))
    cost: float = quantity("1", "value of the cost")
    decrease: float = quantity("1", "relative decrease of the cost in the last iteration")
    iterations: float = quantity("1", "iterations that lowered the cost")


@record
class _Sample:
    x: ConstrainedMpcState
    y: PredictiveOutputs


@final
@block(CONTROLLER)
class ConstrainedMpc(Guidance, ConstrainedSettings, Sampled[ControllerInputs, ConstrainedMpcState, PredictiveOutputs]):
    """Integrated planning and tracking that respects friction and takes obstacles and edges as constraints.

    The paper's idea with what its own numbers ask for (compare `mpc`):

    * the prediction is integrated by Runge-Kutta steps at the sampling time over 2 s, with tyres that saturate;
    * obstacles and edges are constraints on the vehicle's whole body, with a slack that costs `c_edge` times its
      square, instead of a potential of its centre of gravity that can be crossed;
    * the share of the friction limit that linear tyres would ask for is a constraint with slack, too;
    * the steering rate is weighted and bounded;
    * the path's arcs can use a share `mu_share` of the friction, to leave some for corrections.

    Solved by `ilqr`, a bounded number of iterations from the previous plan shifted by one step. `solver.kkt` is the
    relative decrease of the cost in the last iteration. Obstacles that the path does not pass beside (one that is
    followed) do not narrow the corridor: the planner's speed keeps the distance.
    Feedthrough: all inputs to all outputs.
    """

    name: ClassVar[str] = "mpc_plus"
    staged: ClassVar[bool] = True
    N_p: ClassVar[int] = PREDICTION_STEPS

    mu_share: float = quantity("1", "share of the friction that the arcs of the path use", min=0.1, max=1)

    def start(self) -> ConstrainedMpcState:
        """No manoeuvre, wheels straight."""
        return ConstrainedMpcState(manoeuvre=no_manoeuvre(), u=vector([0.0] * _INPUTS), delta_f=0.0)

    def radius(self) -> float:
        """Radius of the arcs of a lane change [m], with a share of the friction."""
        return dubins.radius(self.v_ref, self.mu_share * self.mu, self.g)

    def progress(self, v: float, v_d: float, t: float) -> float:
        """The desired point speeds up or slows down with `a_follow`, as the vehicle can."""
        change = fmin(absolute(v_d - v), self.a_follow * t)
        return v * t + sign(v_d - v) * change * (t - change / (2 * fmax(self.a_follow, 1e-3)))

    def beside(self, obstacles: ObstacleList, y_d: float) -> ObstacleList:
        """The obstacles that a path at `y_d` passes beside, grown by the length of the ego vehicle."""
        apart = absolute(self.y_adjacent - self.y_lane) / 2
        passed = [where(absolute(obstacles.y[i] - y_d) > apart, obstacles.valid[i], 0.0) for i in range(SLOTS)]
        return ObstacleList(
            valid=vector(passed),
            id=obstacles.id,
            x=obstacles.x,
            y=obstacles.y,
            psi=obstacles.psi,
            v=obstacles.v,
            length=obstacles.length + self.ego_length,
            width=obstacles.width,
        )

    def sample(self, x: ConstrainedMpcState, u: ControllerInputs) -> tuple[ConstrainedMpcState, PredictiveOutputs]:
        """Plan anew, from the previous plan shifted by one step."""
        dims = self.dimensions()
        task = staged(_task, _Task, dims, self, x, u)
        constants = part(ConstrainedProblem, self)
        trajectory = ilqr.optimise(
            STAGES, constants, task.targets, task.now, task.guess, N=PREDICTION_STEPS, iterations=_ITERATIONS
        )
        sample = staged(_followed, _Sample, dims, self, x, task, _Found(**vars(trajectory)))
        return sample.x, sample.y


def _task(self: ConstrainedMpc, x: ConstrainedMpcState, u: ControllerInputs) -> _Task:
    reference = self.reference(x.manoeuvre, u)
    horizon, ego = reference.horizon, u.ego
    targets: list[StageTarget] = []
    v_d, v = reference.manoeuvre.v_d, ego.v_x
    for i in [0, *range(PREDICTION_STEPS)]:  # the first stage is the present, which cannot be changed
        reach = self.a_follow * self.dt * (i + 1)
        target = StageTarget(
            x_d=horizon.x_d[i],
            y_d=horizon.y_d[i],
            y_upper=horizon.y_upper[i],
            y_lower=horizon.y_lower[i],
            v_d=clip(v_d, v - reach, v + reach),
        )
        targets.append(target)
    now = SteeredVehicle(x=ego.x, y=ego.y, psi=ego.psi, v_x=ego.v_x, v_y=ego.v_y, r=ego.r, delta_f=x.delta_f)
    _, *later = unpack_all(StageInput, x.u)
    return _Task(reference=reference, now=now, targets=pack_all(targets), guess=pack_all([*later, later[-1]]))


def _followed(self: ConstrainedMpc, x: ConstrainedMpcState, task: _Task, found: _Found) -> _Sample:
    """The plan that was found, or the previous one where the search gave no numbers."""
    end = Solution(z=found.u, cost=found.cost, kkt=found.decrease, iterations=found.iterations)
    u, solver = accepted(end, task.guess, _CONVERGED)
    first = unpack_all(StageInput, u)[0]
    delta_f = clip(x.delta_f + self.dt * first.delta_rate, -self.delta_max, self.delta_max)
    actuation = Actuation(delta_f=delta_f, T_r=clip(self.T_scale * first.T_r, -self.T_bmax, self.T_dmax))
    _, *predicted = unpack_all(SteeredVehicle, found.x)
    plan = shown_plan(task.reference.horizon, predicted, solver)
    return _Sample(
        x=ConstrainedMpcState(manoeuvre=task.reference.manoeuvre, u=u, delta_f=delta_f),
        y=PredictiveOutputs(actuation=actuation, path=task.reference.path, plan=plan, solver=solver),
    )
