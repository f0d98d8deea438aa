"""The optimal control problem of `constrained_mpc`, stage by stage, as text.

States are the vehicle's and its steering angle; inputs are the steering rate and the torque. Each stage weighs the
distance to the path, the speed error, the yaw acceleration and the inputs, and holds the body inside the corridor and
the tyres inside their friction limit, with slack.
"""

from __future__ import annotations

from components.controller.algorithms import ilqr
from components.controller.problems.ocp import PredictedVehicle, speed_that_holds
from components.interfaces.frames import slip_angle, to_road
from components.interfaces.maths import absolute, cos, fmax, sin, sqrt, tanh
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.runge_kutta import runge_kutta


@record
class SteeredVehicle:
    """The predicted vehicle; the steering angle is a state, its rate an input."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road")
    psi: float = quantity("rad", "yaw angle")
    v_x: float = quantity("m/s", "longitudinal speed")
    v_y: float = quantity("m/s", "lateral speed")
    r: float = quantity("rad/s", "yaw rate")
    delta_f: float = quantity("rad", "front road-wheel angle")


@record
class StageInput:
    """What is optimised at each prediction step."""

    delta_rate: float = quantity("rad/s", "steering rate")
    T_r: float = quantity("1", "torque on one rear wheel, in units of T_scale")


@record
class StageTarget:
    """Where the vehicle should be in a prediction step, how fast, and the corridor that it should stay in."""

    x_d: float = quantity("m", "desired point, along the road")
    y_d: float = quantity("m", "desired point, across the road")
    y_upper: float = quantity("m", "upper boundary of the corridor")
    y_lower: float = quantity("m", "lower boundary of the corridor")
    v_d: float = quantity("m/s", "desired speed")


@record
class ConstrainedSettings(PredictedVehicle):
    """The vehicle, the weights and the limits of the optimisation."""

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
class ConstrainedProblem(ConstrainedSettings):
    """The settings, and the environment that they are relative to."""

    mu: float = quantity("1", "friction coefficient of the road")
    g: float = quantity("m/s2", "gravity")
    dt: float = quantity("s", "prediction step")


def loads(p: ConstrainedProblem) -> tuple[float, float]:
    """Static loads of one front and one rear tyre [N]."""
    total = p.m * p.g / 2 / (p.l_f + p.l_r)
    return total * p.l_r, total * p.l_f


def demands(p: ConstrainedProblem, x: SteeredVehicle) -> tuple[float, float]:
    """The forces of linear tyres (2), (3), as signed shares of the friction limit."""
    F_zf, F_zr = loads(p)
    v_least = speed_that_holds(p, p.dt)
    alpha_f = slip_angle(x.v_x, x.v_y + p.l_f * x.r, x.delta_f, v_least)  # (3)
    alpha_r = slip_angle(x.v_x, x.v_y - p.l_r * x.r, 0.0, v_least)  # (3)
    return p.C_alpha_f * alpha_f / (p.mu * F_zf), p.C_alpha_r * alpha_r / (p.mu * F_zr)


def derivative(p: ConstrainedProblem, x: SteeredVehicle, u: StageInput) -> SteeredVehicle:
    """Equations of motion (1) with tyres that saturate at the friction limit."""
    F_zf, F_zr = loads(p)
    front, rear = demands(p, x)
    F_cf, F_cr = -p.mu * F_zf * tanh(front), -p.mu * F_zr * tanh(rear)
    x_dot, y_dot = to_road(x.psi, x.v_x, x.v_y)
    F_x = p.T_scale * u.T_r / p.R_w
    return SteeredVehicle(
        x=x_dot,
        y=y_dot,
        psi=x.r,
        v_x=x.r * x.v_y - 2 / p.m * (F_cf * sin(x.delta_f) - F_x),  # (1)
        v_y=-x.r * x.v_x + 2 / p.m * (F_cf * cos(x.delta_f) + F_cr),  # (1)
        r=2 / p.I_z * (p.l_f * F_cf - p.l_r * F_cr),  # (1)
        delta_f=u.delta_rate,
    )


def predict(p: ConstrainedProblem, x: SteeredVehicle, u: StageInput) -> SteeredVehicle:
    """The state one prediction step later; the steering angle changes at its start and is held, as in the vehicle."""
    held = SteeredVehicle(x=x.x, y=x.y, psi=x.psi, v_x=x.v_x, v_y=x.v_y, r=x.r, delta_f=x.delta_f + p.dt * u.delta_rate)
    still = StageInput(delta_rate=0.0, T_r=u.T_r)
    return runge_kutta(lambda state: derivative(p, state, still), held, p.dt)


def residual(p: ConstrainedProblem, stage: StageTarget, x: SteeredVehicle, u: StageInput) -> list[float]:
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


def bounds(p: ConstrainedProblem) -> tuple[StageInput, StageInput]:
    """Lower and upper inputs."""
    return (
        StageInput(delta_rate=-p.delta_rate_max, T_r=-p.T_bmax / p.T_scale),
        StageInput(delta_rate=p.delta_rate_max, T_r=p.T_dmax / p.T_scale),
    )


STAGES = ilqr.Stages(ConstrainedProblem, StageTarget, SteeredVehicle, StageInput, predict, residual, bounds)
