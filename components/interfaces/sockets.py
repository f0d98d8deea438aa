"""The sockets of a system, and records of their required buses; no other file describes a socket."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from components.interfaces.buses import Actuation, Motion, ObstacleList, Plan, Solver, Tyre, VehicleState, Waypoints
from components.interfaces.problem import refuse
from components.interfaces.record import record
from components.interfaces.socket import BusTraits, Position, Reading, Socket


@record
class PlantInputs:
    """The buses that a plant reads."""

    actuation: Actuation


@record
class PlantOutputs:
    """The buses that every plant shows."""

    state: VehicleState


@record
class TrafficInputs:
    """The buses that traffic may react to."""

    ego: VehicleState


@record
class TrafficOutputs:
    """The buses that traffic shows."""

    obstacles: ObstacleList


@record
class ControllerInputs:
    """The buses that a controller reads."""

    ego: VehicleState
    obstacles: ObstacleList


@record
class ControllerOutputs:
    """The buses that every controller shows."""

    actuation: Actuation


_VEHICLE: Final = BusTraits(other_names=("state", "ego", "vehiclestate"), position=Position.VEHICLE)
_EGO: Final = BusTraits(
    other_names=("ego", "state", "egostate", "vehiclestate"), position=Position.VEHICLE, driven_by="plant.state"
)
_OBSTACLES: Final = BusTraits(
    other_names=("obstacles", "obstacle", "objects", "object"),
    position=Position.BOX,
    partial=True,
    numbered=("id", "x"),
)

PLANT: Final = Socket(
    name="plant",
    inputs={"actuation": Actuation},
    outputs={"state": VehicleState},
    optional={"tyre": Tyre, "motion": Motion},
    traits={
        "actuation": BusTraits(driven_by="controller.actuation", must_read=Reading.EVERYTHING),
        "state": _VEHICLE,
    },
    acts_through_step=True,
    essential=True,
    other_names=("vehicle",),
)
TRAFFIC: Final = Socket(
    name="traffic",
    inputs={"ego": VehicleState},
    outputs={"obstacles": ObstacleList},
    traits={"ego": _EGO, "obstacles": _OBSTACLES},
    acts_through_step=True,
    essential=True,
    substitute="Other traffic",
)
CONTROLLER: Final = Socket(
    name="controller",
    inputs={"ego": VehicleState, "obstacles": ObstacleList},
    outputs={"actuation": Actuation},
    optional={"path": Waypoints, "plan": Plan, "solver": Solver},
    traits={
        "ego": replace(_EGO, must_read=Reading.SOMETHING),
        "obstacles": replace(_OBSTACLES, driven_by="traffic.obstacles", must_read=Reading.DESIRED),
    },
    essential=True,
)

SOCKETS: Final[dict[str, Socket]] = {socket.name: socket for socket in (PLANT, TRAFFIC, CONTROLLER)}
"""All sockets that are known, by name; `add_socket` adds another."""


def add_socket(socket: Socket) -> None:
    """Register another socket for scenarios, mapping files, checks and the command.

    Args:
        socket: The new socket; blocks that fill it are added to the catalogue of `components`.

    Raises:
        RequestError: Another socket has this name already.
    """
    if SOCKETS.setdefault(socket.name, socket) is not socket:
        raise refuse(f"socket `{socket.name}`", "a socket of this name", "a name that no other socket has")


def remove_socket(name: str) -> None:
    """Remove a socket that `add_socket` has added; another, or one that is not there, stays as it is.

    Args:
        name: The socket's name.
    """
    if name not in {PLANT.name, TRAFFIC.name, CONTROLLER.name}:
        SOCKETS.pop(name, None)


def standard_wiring(names: Iterable[str] | None = None) -> dict[str, str]:
    """The connections between units that fill sockets, where each unit has the name of its socket.

    Args:
        names: The sockets that are filled; all that are known if not given.

    Returns:
        The output bus that drives each input bus, in the form of `System.wiring`; input buses whose driver is not among
        the `names` are left out.
    """
    filled = [*(SOCKETS if names is None else names)]
    wires = {bus: source for name in filled for bus, source in SOCKETS[name].wiring.items()}
    return {bus: source for bus, source in wires.items() if source.partition(".")[0] in filled}
