"""A controller that keeps the paper's idea, planning and tracking in one optimisation, and repairs what it breaks."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, final

from components.controller import dubins, ilqr
from components.controller.planner import Manoeuvre, no_manoeuvre
from components.controller.reference import Guidance, Reference
from components.interfaces.block import Sampled, block
from components.interfaces.buses import SLOTS, Actuation, ObstacleList, Plan, Solver, SolverStatus, Waypoints
from components.interfaces.frames import to_road
from components.interfaces.maths import (
    Array,
    absolute,
    both,
    clip,
    cos,
    fmax,
    fmin,
    joined,
    sign,
    sin,
    sqrt,
    tanh,
    vector,
    where,
)
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.runge_kutta import runge_kutta
from components.interfaces.sockets import CONTROLLER, ControllerInputs
from components.interfaces.staging import staged

N_P = 20
"""Prediction steps: 2 s at the sampling time."""

ITERATIONS = 6
LARGEST = 1e9
CONVERGED = 1e-3
"""A last iteration that lowers the cost by a smaller share has converged."""


@record
class PlusState:
    """The predicted vehicle; the steering angle is a state, its rate an input."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    psi: float = quantity("rad", "yaw angle")
    v_x: float = quantity("m/s", "longitudinal speed")
    v_y: float = quantity("m/s", "lateral speed")
    r: float = quantity("rad/s", "yaw rate")
    delta_f: float = quantity("rad", "front road-wheel angle")


@record
class PlusInput:
    """What is optimised at each prediction step."""

    delta_rate: float = quantity("rad/s", "steering rate")
    T_r: float = quantity("1", "torque on one rear wheel, in units of T_scale")


@record
class PlusStage:
    """What a prediction step is asked for."""

    x_d: float = quantity("m", "desired point, along the road")
    y_d: float = quantity("m", "desired point, across the road")
    y_upper: float = quantity("m", "upper boundary of the corridor")
    y_lower: float = quantity("m", "lower boundary of the corridor")
    v_d: float = quantity("m/s", "desired speed")


@record
class PlusConstants:
    """The vehicle, the weights and the limits of the optimisation."""

    m: float = quantity("kg", "mass of the predicted vehicle", min=1)
    I_z: float = quantity("kg.m2", "yaw inertia of the predicted vehicle", min=1)
    l_f: float = quantity("m", "distance from the centre of gravity to the front axle", min=0.1)
    l_r: float = quantity("m", "distance from the centre of gravity to the rear axle", min=0.1)
    C_alpha_f: float = quantity("N/rad", "cornering stiffness of one front tyre", min=0)
    C_alpha_r: float = quantity("N/rad", "cornering stiffness of one rear tyre", min=0)
    R_w: float = quantity("m", "wheel radius", min=0.01)
    ego_length: float = quantity("m", "length of the ego vehicle", min=0)
    ego_width: float = quantity("m", "width of the ego vehicle", min=0)
    a_1: float = quantity("1/m2", "weight of the distance to the path", min=0)
    a_v: float = quantity("s2/m2", "weight of the speed error", min=0)
    b_3: float = quantity("s4/rad2", "weight of the yaw acceleration", min=0)
    b_delta: float = quantity("s2/rad2", "weight of the steering rate", min=0)
    b_T: float = quantity("1", "weight of the torque, in units of T_scale", min=0)
    c_edge: float = quantity("1/m2", "weight of the slack of the corridor", min=0)
    c_mu: float = quantity("1", "weight of the slack of the friction limit", min=0)
    mu_limit: float = quantity("1", "share of the friction limit that a linear tyre may ask for", min=0.1)
    l_margin: float = quantity("m", "distance that the body keeps from the corridor's boundaries", min=0)
    delta_max: float = quantity("rad", "largest front road-wheel angle", min=0.001, max=1.5)
    delta_rate_max: float = quantity("rad/s", "largest steering rate", min=0.01)
    T_dmax: float = quantity("N.m", "largest driving torque on one rear wheel", min=0)
    T_bmax: float = quantity("N.m", "largest braking torque on one rear wheel", min=0)
    T_scale: float = quantity("N.m", "unit of the torques in the optimisation", min=1e-6)


@record
class PlusProblem(PlusConstants):
    """The constants, and what they are relative to."""

    mu: float = quantity("1", "friction coefficient of the road")
    g: float = quantity("m/s2", "gravity")
    dt: float = quantity("s", "prediction step")


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


def loads(p: PlusProblem) -> tuple[float, float]:
    """Static loads of one front and one rear tyre."""
    total = p.m * p.g / 2 / (p.l_f + p.l_r)
    return total * p.l_r, total * p.l_f


def demands(p: PlusProblem, x: PlusState) -> tuple[float, float]:
    """What linear tyres (2), (3) would ask for, as shares of the friction limit, with sign."""
    F_zf, F_zr = loads(p)
    alpha_f = (x.v_y + p.l_f * x.r) / x.v_x - x.delta_f  # (3)
    alpha_r = (x.v_y - p.l_r * x.r) / x.v_x  # (3)
    return p.C_alpha_f * alpha_f / (p.mu * F_zf), p.C_alpha_r * alpha_r / (p.mu * F_zr)


def derivative(p: PlusProblem, x: PlusState, u: PlusInput) -> PlusState:
    """Equations of motion (1) with tyres that saturate at the friction limit."""
    F_zf, F_zr = loads(p)
    front, rear = demands(p, x)
    F_cf, F_cr = -p.mu * F_zf * tanh(front), -p.mu * F_zr * tanh(rear)
    x_dot, y_dot = to_road(x.psi, x.v_x, x.v_y)
    F_x = p.T_scale * u.T_r / p.R_w
    return PlusState(
        x=x_dot,
        y=y_dot,
        psi=x.r,
        v_x=x.r * x.v_y - 2 / p.m * (F_cf * sin(x.delta_f) - F_x),  # (1)
        v_y=-x.r * x.v_x + 2 / p.m * (F_cf * cos(x.delta_f) + F_cr),  # (1)
        r=2 / p.I_z * (p.l_f * F_cf - p.l_r * F_cr),  # (1)
        delta_f=u.delta_rate,
    )


def predict(p: PlusProblem, x: PlusState, u: PlusInput) -> PlusState:
    """The state one prediction step later: the angle is reached at once and held, as the vehicle will have it."""
    held = PlusState(x=x.x, y=x.y, psi=x.psi, v_x=x.v_x, v_y=x.v_y, r=x.r, delta_f=x.delta_f + p.dt * u.delta_rate)
    still = PlusInput(delta_rate=0.0, T_r=u.T_r)
    return runge_kutta(lambda state: derivative(p, state, still), held, p.dt)


def residual(p: PlusProblem, stage: PlusStage, x: PlusState, u: PlusInput) -> list[float]:
    """Weighted residuals of one prediction step; the last four are constraints with slack."""
    r_dot = derivative(p, x, u).r
    front, rear = demands(p, x)
    reach = p.ego_width / 2 * cos(x.psi) + p.ego_length / 2 * sqrt(sin(x.psi) * sin(x.psi) + 1e-6) + p.l_margin
    return [
        sqrt(p.a_1) * (x.x - stage.x_d),
        sqrt(p.a_1) * (x.y - stage.y_d),
        sqrt(p.a_v) * (x.v_x - stage.v_d),
        sqrt(p.b_3) * r_dot,
        sqrt(p.b_delta) * u.delta_rate,
        sqrt(p.b_T) * u.T_r,
        sqrt(p.c_edge) * fmax(x.y + reach - stage.y_upper, 0.0),
        sqrt(p.c_edge) * fmax(stage.y_lower - x.y + reach, 0.0),
        sqrt(p.c_mu) * fmax(absolute(front) - p.mu_limit, 0.0),
        sqrt(p.c_mu) * fmax(absolute(rear) - p.mu_limit, 0.0),
        sqrt(p.c_edge) * fmax(absolute(x.delta_f) - p.delta_max, 0.0),
    ]


def bounds(p: PlusProblem) -> tuple[PlusInput, PlusInput]:
    """Lower and upper inputs."""
    return (
        PlusInput(delta_rate=-p.delta_rate_max, T_r=-p.T_bmax / p.T_scale),
        PlusInput(delta_rate=p.delta_rate_max, T_r=p.T_dmax / p.T_scale),
    )


STAGES = ilqr.Stages(PlusProblem, PlusStage, PlusState, PlusInput, predict, residual, bounds)


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
    * the path's arcs use a share `mu_share` of the friction, so that there is some left to correct with.

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
        names = [field.name for field in dataclasses.fields(PlusProblem)]
        return PlusProblem(**{name: getattr(self, name) for name in names})


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
