"""The optimal control problem of the MP algorithm, (5)-(9) of the paper, as text.

    minimise over delta_f(k..k+N_p-1), T_r(k..k+N_p-1)

    J = sum over i = 1..N_p of   a_1 [(x - X_d)^2 + (y - Y_d)^2]            follow the path
                               + b_1 / [(x - X_u)^2 + (y - Y_u)^2]^2        keep off the upper boundary
                               + b_2 / [(x - X_l)^2 + (y - Y_l)^2]^2        keep off the lower boundary
                               + b_3 r_dot^2                                turn smoothly          (5)

    subject to   -delta_max <= delta_f <= delta_max,   -T_bmax <= T_r <= T_dmax

with x, y at k+i predicted by explicit Euler steps of `dt` (6)-(9). The states are eliminated (single shooting), which
leaves 2 N_p variables with bounds only: delta_f / delta_scale and T_r / T_scale, first all angles, then all torques.
"""

from __future__ import annotations

from typing import Any

from components.interfaces.buses import Plan, VehicleState
from components.interfaces.frames import slip_angle, to_road
from components.interfaces.maths import Array, cos, fmax, sin, vector
from components.interfaces.quantity import quantity
from components.interfaces.record import record

CLOSEST = 1e-3
"""[m2] Squared distances to a boundary are clipped here: the term is a penalty, not a barrier (RESOLUTIONS 15)."""


@record
class PredictedVehicle:
    """The vehicle as the controller knows it."""

    m: float = quantity("kg", "mass of the predicted vehicle", min=1)
    I_z: float = quantity("kg.m2", "yaw inertia of the predicted vehicle", min=1)
    l_f: float = quantity("m", "distance from the centre of gravity to the front axle", min=0.1)
    l_r: float = quantity("m", "distance from the centre of gravity to the rear axle", min=0.1)
    C_alpha_f: float = quantity("N/rad", "cornering stiffness of one front tyre", min=0)
    C_alpha_r: float = quantity("N/rad", "cornering stiffness of one rear tyre", min=0)
    R_w: float = quantity("m", "wheel radius", min=0.01)


@record
class Weights:
    """Scaling factors of the cost (5)."""

    a_1: float = quantity("1/m2", "weight of the distance to the path")
    b_1: float = quantity("m4", "weight of the upper boundary")
    b_2: float = quantity("m4", "weight of the lower boundary")
    b_3: float = quantity("s4/rad2", "weight of the yaw acceleration")


@record
class Horizon:
    """The references and boundaries of the prediction steps."""

    x_d: Array = quantity("m", "desired point X_d", shape=("N_p",))
    y_d: Array = quantity("m", "desired point Y_d", shape=("N_p",))
    y_upper: Array = quantity("m", "upper boundary Y_u at X_d", shape=("N_p",))
    y_lower: Array = quantity("m", "lower boundary Y_l at X_d", shape=("N_p",))

    @property
    def steps(self) -> int:
        """Number of prediction steps."""
        return self.x_d.shape[0]

    def plan(self, x: Array, y: Array) -> Plan:
        """The bus `plan` for the predicted positions `x` and `y`, each of shape (N_p,)."""
        return Plan(x=x, y=y, x_d=self.x_d, y_d=self.y_d, y_upper=self.y_upper, y_lower=self.y_lower)


def by_input(z: Array) -> tuple[Array, Array]:
    """The two halves of a decision of shape (2 N_p,): the first input at k..k+N_p-1, then the second."""
    N_p = z.shape[0] // 2
    return z[:N_p], z[N_p:]


def speed_that_holds(vehicle: PredictedVehicle, dt: float) -> float:
    """The speed [m/s] from which on one step of `dt` [s] is short enough for the lateral dynamics of a vehicle.

    With linear tyres these decay at the rates ``2 (C_f + C_r) / (m v_x)`` and
    ``2 (l_f^2 C_f + l_r^2 C_r) / (I_z v_x)``, faster and faster towards rest. An explicit Euler step holds while rate
    times step is below 2; 1.5 leaves room.
    """
    front, rear = vehicle.C_alpha_f, vehicle.C_alpha_r
    lateral = 2 * (front + rear) / vehicle.m
    turning = 2 * (vehicle.l_f * vehicle.l_f * front + vehicle.l_r * vehicle.l_r * rear) / vehicle.I_z
    return fmax(lateral, turning) * dt / 1.5


def predict(vehicle: PredictedVehicle, before: VehicleState, delta_f: float, T_r: float, dt: float) -> VehicleState:
    """The state one prediction step later, (6)-(9) with the corrections RESOLUTIONS 1, 2 and 10.

    Args:
        vehicle: The vehicle as the controller knows it.
        before: The state one prediction step earlier.
        delta_f: Front road-wheel angle [rad], held during the step.
        T_r: Torque on one rear wheel [N.m], held during the step.
        dt: Prediction step [s].
    """
    v_least = speed_that_holds(vehicle, dt)
    F_cf = -vehicle.C_alpha_f * slip_angle(before.v_x, before.v_y + vehicle.l_f * before.r, delta_f, v_least)  # (9)
    F_cr = -vehicle.C_alpha_r * slip_angle(before.v_x, before.v_y - vehicle.l_r * before.r, 0.0, v_least)  # (9)
    v_x = before.v_x + (before.v_y * before.r - 2 * (F_cf * sin(delta_f) - T_r / vehicle.R_w) / vehicle.m) * dt  # (8)
    v_y = before.v_y + (-before.v_x * before.r + 2 * (F_cf * cos(delta_f) + F_cr) / vehicle.m) * dt  # (8)
    r = before.r + 2 * (vehicle.l_f * F_cf - vehicle.l_r * F_cr) / vehicle.I_z * dt  # (8)
    psi = before.psi + before.r * dt  # (8)
    v_xg, v_yg = to_road(psi, v_x, v_y)  # (7)
    return VehicleState(x=before.x + v_xg * dt, y=before.y + v_yg * dt, psi=psi, v_x=v_x, v_y=v_y, r=r)  # (6)


@record
class OptimalControlProblem:
    """The optimal control problem of one sample, in scaled decisions ``z = (delta_f / delta_scale, T_r / T_scale)``."""

    vehicle: PredictedVehicle
    weights: Weights
    horizon: Horizon
    start: VehicleState
    dt: float = quantity("s", "prediction step")
    delta_max: float = quantity("rad", "largest front road-wheel angle")
    T_dmax: float = quantity("N.m", "largest driving torque on one rear wheel")
    T_bmax: float = quantity("N.m", "largest braking torque on one rear wheel")
    delta_scale: float = quantity("rad", "unit of the angles in z")
    T_scale: float = quantity("N.m", "unit of the torques in z")

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of z, of shape (2 N_p,)."""
        N_p = self.horizon.steps
        delta, drive, brake = self.delta_max / self.delta_scale, self.T_dmax / self.T_scale, self.T_bmax / self.T_scale
        return vector([-delta] * N_p + [-brake] * N_p), vector([delta] * N_p + [drive] * N_p)

    def controls(self, z: Array) -> list[tuple[Any, Any]]:
        """(delta_f, T_r) at k..k+N_p-1 for the scaled decision `z`."""
        angles, torques = by_input(z)
        return [(self.delta_scale * angles[i], self.T_scale * torques[i]) for i in range(angles.shape[0])]

    def prediction(self, z: Array) -> list[VehicleState]:
        """The predicted states at k+1..k+N_p."""
        states: list[VehicleState] = []
        now = self.start
        for delta_f, T_r in self.controls(z):
            now = predict(self.vehicle, now, delta_f, T_r, self.dt)
            states.append(now)
        return states

    def cost(self, z: Array) -> float:
        """J of (5)."""
        w, horizon = self.weights, self.horizon
        total, r_before = 0.0, self.start.r
        for i, x in enumerate(self.prediction(z)):
            r_dot = (x.r - r_before) / self.dt
            total = total + distance_cost(w, horizon, i, x.x, x.y) + w.b_3 * r_dot * r_dot  # (5)
            r_before = x.r
        return total


def distance_cost(w: Weights, horizon: Horizon, i: int, x: float, y: float) -> float:
    """The part of (5) for the position (x, y) [m] in prediction step i: distances to the path and the boundaries."""
    along = (x - horizon.x_d[i]) * (x - horizon.x_d[i])
    across = (y - horizon.y_d[i]) * (y - horizon.y_d[i])
    upper = along + (y - horizon.y_upper[i]) * (y - horizon.y_upper[i])
    lower = along + (y - horizon.y_lower[i]) * (y - horizon.y_lower[i])
    return w.a_1 * (along + across) + w.b_1 * _repulsion(upper) + w.b_2 * _repulsion(lower)  # (5)


def _repulsion(square: float) -> float:
    kept = fmax(square, CLOSEST)
    return 1 / (kept * kept)
