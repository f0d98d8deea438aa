"""The three sockets of a system, and the records of their required buses."""

from __future__ import annotations

from components.interfaces.buses import Actuation, Motion, ObstacleList, Plan, Solver, Tyre, VehicleState, Waypoints
from components.interfaces.record import record
from components.interfaces.socket import Socket


@record
class PlantInputs:
    """What a plant reads."""

    actuation: Actuation


@record
class PlantOutputs:
    """What every plant shows."""

    state: VehicleState


@record
class TrafficInputs:
    """What traffic may react to."""

    ego: VehicleState


@record
class TrafficOutputs:
    """What traffic shows."""

    obstacles: ObstacleList


@record
class ControllerInputs:
    """What a controller reads."""

    ego: VehicleState
    obstacles: ObstacleList


@record
class ControllerOutputs:
    """What every controller shows."""

    actuation: Actuation


PLANT = Socket(
    name="plant",
    inputs={"actuation": Actuation},
    outputs={"state": VehicleState},
    optional={"tyre": Tyre, "motion": Motion},
)
TRAFFIC = Socket(
    name="traffic",
    inputs={"ego": VehicleState},
    outputs={"obstacles": ObstacleList},
    optional={},
)
CONTROLLER = Socket(
    name="controller",
    inputs={"ego": VehicleState, "obstacles": ObstacleList},
    outputs={"actuation": Actuation},
    optional={"path": Waypoints, "plan": Plan, "solver": Solver},
)

SOCKETS = {socket.name: socket for socket in (PLANT, TRAFFIC, CONTROLLER)}
