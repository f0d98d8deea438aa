"""The buses: closed groups of signals that blocks exchange, in SI units, axes after ISO 8855."""

from __future__ import annotations

from enum import IntEnum
from typing import Final

from components.interfaces.maths import Array
from components.interfaces.quantity import boolean, enumeration, integer, quantity
from components.interfaces.record import record

SLOTS: Final = 8
"""Obstacles that fit the `obstacles` bus."""

WAYPOINTS: Final = 15
"""Waypoints P0..P14 of the path."""


@record
class VehicleState:
    """Where the vehicle is and how it moves; position of the centre of gravity in the road frame."""

    x: float = quantity("m", "position along the road")
    y: float = quantity("m", "position across the road, to the left")
    psi: float = quantity("rad", "yaw angle")
    v_x: float = quantity("m/s", "longitudinal speed in the body frame")
    v_y: float = quantity("m/s", "lateral speed in the body frame, to the left")
    r: float = quantity("rad/s", "yaw rate")


@record
class Actuation:
    """What the controller asks of the vehicle."""

    delta_f: float = quantity("rad", "front road-wheel angle, to the left")
    T_r: float = quantity("N.m", "torque on one rear wheel, driving positive")


@record
class Tyre:
    """How hard the tyres work."""

    alpha_f: float = quantity("rad", "front slip angle")
    alpha_r: float = quantity("rad", "rear slip angle")
    F_cf: float = quantity("N", "lateral force of one front tyre, to the left")
    F_cr: float = quantity("N", "lateral force of one rear tyre, to the left")
    mu_f: float = quantity("1", "share of the friction limit in use at the front axle")
    mu_r: float = quantity("1", "share of the friction limit in use at the rear axle")


@record
class Motion:
    """Accelerations of the centre of gravity, resolved in the body frame."""

    a_x: float = quantity("m/s2", "longitudinal acceleration")
    a_y: float = quantity("m/s2", "lateral acceleration, to the left")
    r_dot: float = quantity("rad/s2", "yaw acceleration")


@record
class ObstacleList:
    """The traffic around the vehicle: one element per slot, box centres in the road frame."""

    valid: Array = boolean("whether the slot holds an obstacle", shape=(SLOTS,))
    id: Array = integer("identity of the obstacle", shape=(SLOTS,))
    x: Array = quantity("m", "position along the road", shape=(SLOTS,))
    y: Array = quantity("m", "position across the road, to the left", shape=(SLOTS,))
    psi: Array = quantity("rad", "yaw angle", shape=(SLOTS,))
    v: Array = quantity("m/s", "speed along the obstacle's heading", shape=(SLOTS,))
    length: Array = quantity("m", "length of the box", shape=(SLOTS,))
    width: Array = quantity("m", "width of the box", shape=(SLOTS,))


@record
class Waypoints:
    """The waypoints P0..P14 of the path."""

    x: Array = quantity("m", "waypoints along the road", shape=(WAYPOINTS,))
    y: Array = quantity("m", "waypoints across the road, to the left", shape=(WAYPOINTS,))


@record
class Plan:
    """What the controller expects at its prediction steps i = 1..N_p."""

    x: Array = quantity("m", "predicted position along the road", shape=("N_p",))
    y: Array = quantity("m", "predicted position across the road", shape=("N_p",))
    x_d: Array = quantity("m", "desired point on the path, along the road", shape=("N_p",))
    y_d: Array = quantity("m", "desired point on the path, across the road", shape=("N_p",))
    y_upper: Array = quantity("m", "upper (left) boundary of the corridor at x_d", shape=("N_p",))
    y_lower: Array = quantity("m", "lower (right) boundary of the corridor at x_d", shape=("N_p",))


class SolverStatus(IntEnum):
    """How a solve ended."""

    converged = 1
    iteration_limit = 2
    fallback = 3


@record
class Solver:
    """How the optimal control problem was solved."""

    status: int = enumeration(SolverStatus, "how the solve ended")
    iterations: int = integer("iterations until the residual was small enough", min=0)
    cost: float = quantity("1", "value of the cost function")
    kkt: float = quantity("1", "residual of the optimality (KKT) conditions")
