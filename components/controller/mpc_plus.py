"""A controller that keeps the paper's idea, planning and tracking in one optimisation, and repairs what it breaks."""

from __future__ import annotations

from typing import ClassVar, final

from components.controller import dubins
from components.controller.algorithms import ilqr
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.problems.constrained_ocp import STAGES, PlusConstants, PlusProblem, PlusState
from components.controller.reference import Guidance, Reference
from components.interfaces.block import Sampled, block
from components.interfaces.buses import SLOTS, Actuation, ObstacleList, Plan, Solver, SolverStatus, Waypoints
from components.interfaces.maths import Array, absolute, both, clip, fmax, fmin, joined, sign, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import part, record
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged

N_P = 20
"""Prediction steps: 2 s at the sampling time."""

ITERATIONS = 6
LARGEST = 1e9
CONVERGED = 1e-3
"""A last iteration that lowers the cost by a smaller share has converged."""


@record
class PlusMemory:
    """What the controller remembers: the manoeuvre, its plan, and the angle it asked for last."""

    manoeuvre: Manoeuvre
    u: Array = quantity("1", "inputs of the last plan: rate and torque, step by step", shape=(2 * N_P,))
    delta_f: float = quantity("rad", "last steering angle")


@record
class PlusOutputs:
    """All buses the controller shows."""

    actuation: Actuation
    path: Waypoints
    plan: Plan
    solver: Solver


@record
class PlusTask:
    """What this sample asks for, and where the search for it begins."""

    reference: Reference
    now: PlusState
    stages: Array = quantity("1", "stage data, step by step", shape=(5 * (N_P + 1),))
    guess: Array = quantity("1", "inputs: rate and torque, step by step", shape=(2 * N_P,))


@record
class PlusFound:
    """What the search found."""

    u: Array = quantity("1", "inputs: rate and torque, step by step", shape=(2 * N_P,))
    x: Array = quantity("1", "predicted states, step by step", shape=(7 * (N_P + 1),))
    cost: float = quantity("1", "value of the cost")
    decrease: float = quantity("1", "relative decrease of the cost in the last iteration")
    iterations: float = quantity("1", "iterations that lowered the cost")


@final
@block(CONTROLLER)
class MpcPlus(Guidance, PlusConstants, Sampled[ControllerInputs, PlusMemory, PlusOutputs]):
    """Integrated planning and tracking that respects friction and takes obstacles and edges as constraints.

    The paper's idea with what its own numbers ask for (compare `mpc`):

    * the prediction is integrated by Runge-Kutta steps at the sampling time over 2 s, with tyres that saturate;
    * obstacles and edges are constraints on the vehicle's whole body, with a slack that costs `c_edge` times its
      square, instead of a potential of its centre of gravity that can be crossed;
    * the share of the friction limit that linear tyres would ask for is a constraint with slack, too;
    * the steering rate is weighted and bounded;
    * the path's arcs can use a share `mu_share` of the friction, to leave some for corrections.

    Solved by `ilqr`, a fixed number of iterations from the previous plan shifted by one step. `solver.kkt` is the
    relative decrease of the cost in the last iteration. Obstacles that the path does not pass beside (one that is
    followed) do not narrow the corridor: the planner's speed keeps the distance.
    Feedthrough: all inputs to all outputs. Valid for v_x > 1 m/s.
    """

    staged: ClassVar[bool] = True
    N_p: ClassVar[int] = N_P

    mu_share: float = quantity("1", "share of the friction that the arcs of the path use", min=0.1, max=1)

    def start(self) -> PlusMemory:
        """No manoeuvre, wheels straight."""
        return PlusMemory(manoeuvre=no_manoeuvre(), u=vector([0.0] * (2 * N_P)), delta_f=0.0)

    def shape(self) -> dubins.LaneChange:
        """One lane change of the path, with a share of the friction."""
        R = dubins.radius(self.v_ref, self.mu_share * self.mu, self.g)
        return dubins.LaneChange(w=self.y_adjacent - self.y_lane, R=R, l_d=self.l_d)

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

    def sample(self, x: PlusMemory, u: ControllerInputs) -> tuple[PlusMemory, PlusOutputs]:
        """Plan anew, from the previous plan shifted by one step."""
        dims = self.dimensions()
        task = staged(_task, PlusTask, dims, self, x, u)
        found = ilqr.optimise(STAGES, self.problem(), task.stages, task.now, task.guess, N=N_P, iterations=ITERATIONS)
        return staged(_followed, PlusResult, dims, self, x, task, PlusFound(**vars(found))).parts()

    def problem(self) -> PlusProblem:
        """The constants of the optimisation."""
        return part(PlusProblem, self)


@record
class PlusResult:
    """All that a sample leaves behind."""

    memory: PlusMemory
    outputs: PlusOutputs

    def parts(self) -> tuple[PlusMemory, PlusOutputs]:
        """State and outputs."""
        return self.memory, self.outputs


def _task(self: MpcPlus, x: PlusMemory, u: ControllerInputs) -> PlusTask:
    reference = self.reference(x.manoeuvre, u)
    horizon, ego = reference.horizon, u.ego
    stages: list[float] = []
    v_d, v = reference.manoeuvre.v_d, ego.v_x
    for i in [0, *range(N_P)]:  # the first stage is the present, which cannot be changed
        reach = self.a_follow * self.dt * (i + 1)
        stages += [
            horizon.x_d[i],
            horizon.y_d[i],
            horizon.y_upper[i],
            horizon.y_lower[i],
            clip(v_d, v - reach, v + reach),
        ]
    now = PlusState(x=ego.x, y=ego.y, psi=ego.psi, v_x=ego.v_x, v_y=ego.v_y, r=ego.r, delta_f=x.delta_f)
    return PlusTask(reference=reference, now=now, stages=vector(stages), guess=joined([x.u[2:], x.u[2 * N_P - 2 :]]))


def _followed(self: MpcPlus, x: PlusMemory, task: PlusTask, found: PlusFound) -> PlusResult:
    """The plan that was found, or the previous one where the search gave no numbers."""
    finite = both(absolute(found.cost) < LARGEST, absolute(found.decrease) < LARGEST)  # false for a NaN
    u = vector([where(finite, found.u[i], task.guess[i]) for i in range(2 * N_P)])
    delta_f = clip(x.delta_f + self.dt * u[0], -self.delta_max, self.delta_max)
    actuation = Actuation(delta_f=delta_f, T_r=clip(self.T_scale * u[1], -self.T_bmax, self.T_dmax))
    ended = where(found.decrease < CONVERGED, float(SolverStatus.converged), float(SolverStatus.iteration_limit))
    solver = Solver(
        status=where(finite, ended, float(SolverStatus.fallback)),
        iterations=found.iterations,  # type: ignore[arg-type] # a count among other columns of doubles
        cost=where(finite, found.cost, LARGEST),
        kkt=where(finite, found.decrease, LARGEST),
    )
    horizon = task.reference.horizon
    plan = Plan(
        x=vector([where(finite, found.x[7 * (i + 1)], horizon.x_d[i]) for i in range(N_P)]),
        y=vector([where(finite, found.x[7 * (i + 1) + 1], horizon.y_d[i]) for i in range(N_P)]),
        x_d=horizon.x_d,
        y_d=horizon.y_d,
        y_upper=horizon.y_upper,
        y_lower=horizon.y_lower,
    )
    return PlusResult(
        memory=PlusMemory(manoeuvre=task.reference.manoeuvre, u=u, delta_f=delta_f),
        outputs=PlusOutputs(actuation=actuation, path=task.reference.path, plan=plan, solver=solver),
    )
