"""What is simulated: blocks with typed ports for the sockets of a system, and the contract that they keep.

The public names are imported when they are first used: `import components` itself loads nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from components.interfaces.facade import facade

if TYPE_CHECKING:
    from components.catalogue import BLOCKS, CATALOGUE, EXTRAS, add_block, remove_block
    from components.controller.coast import Coast
    from components.controller.constrained_mpc import ConstrainedMpc
    from components.controller.lqr import Lqr
    from components.controller.mpc import Mpc
    from components.controller.mpc_external import MpcInteriorPoint, MpcSqp
    from components.controller.pure_pursuit import PurePursuit
    from components.controller.stanley import Stanley
    from components.controller.two_level_mp import TwoLevelMp
    from components.interfaces import maths
    from components.interfaces.block import Block, Continuous, NoState, Sampled, block
    from components.interfaces.buses import (
        Actuation,
        Motion,
        ObstacleList,
        Plan,
        Solver,
        SolverStatus,
        Tyre,
        VehicleState,
        Waypoints,
    )
    from components.interfaces.problem import Problem, RequestError
    from components.interfaces.quantity import boolean, enumeration, integer, quantity
    from components.interfaces.record import record
    from components.interfaces.socket import BusTraits, Position, Reading, Socket
    from components.interfaces.sockets import (
        CONTROLLER,
        PLANT,
        SOCKETS,
        TRAFFIC,
        ControllerInputs,
        ControllerOutputs,
        PlantInputs,
        PlantOutputs,
        TrafficInputs,
        TrafficOutputs,
        add_socket,
        remove_socket,
        standard_wiring,
    )
    from components.traffic.dense_traffic import DenseTraffic
    from components.traffic.empty_road import EmptyRoad
    from components.traffic.ramp_traffic import RampTraffic
    from components.vehicle.bicycle import Bicycle
    from components.vehicle.bicycle_saturated import BicycleSaturated
    from components.vehicle.commonroad_mb import CommonroadMb
    from components.vehicle.commonroad_st import CommonroadSt
    from components.vehicle.stationary import Stationary

__all__ = [
    "BLOCKS",
    "CATALOGUE",
    "CONTROLLER",
    "EXTRAS",
    "PLANT",
    "SOCKETS",
    "TRAFFIC",
    "Actuation",
    "Bicycle",
    "BicycleSaturated",
    "Block",
    "BusTraits",
    "Coast",
    "CommonroadMb",
    "CommonroadSt",
    "ConstrainedMpc",
    "Continuous",
    "ControllerInputs",
    "ControllerOutputs",
    "DenseTraffic",
    "EmptyRoad",
    "Lqr",
    "Motion",
    "Mpc",
    "MpcInteriorPoint",
    "MpcSqp",
    "NoState",
    "ObstacleList",
    "Plan",
    "PlantInputs",
    "PlantOutputs",
    "Position",
    "Problem",
    "PurePursuit",
    "RampTraffic",
    "Reading",
    "RequestError",
    "Sampled",
    "Socket",
    "Solver",
    "SolverStatus",
    "Stanley",
    "Stationary",
    "TrafficInputs",
    "TrafficOutputs",
    "TwoLevelMp",
    "Tyre",
    "VehicleState",
    "Waypoints",
    "add_block",
    "add_socket",
    "block",
    "boolean",
    "enumeration",
    "integer",
    "maths",
    "quantity",
    "record",
    "remove_block",
    "remove_socket",
    "standard_wiring",
]

__getattr__, __dir__ = facade(
    __name__,
    {
        "components.catalogue": ("BLOCKS", "CATALOGUE", "EXTRAS", "add_block", "remove_block"),
        "components.controller.coast": ("Coast",),
        "components.controller.constrained_mpc": ("ConstrainedMpc",),
        "components.controller.lqr": ("Lqr",),
        "components.controller.mpc": ("Mpc",),
        "components.controller.mpc_external": ("MpcInteriorPoint", "MpcSqp"),
        "components.controller.pure_pursuit": ("PurePursuit",),
        "components.controller.stanley": ("Stanley",),
        "components.controller.two_level_mp": ("TwoLevelMp",),
        "components.interfaces": ("maths",),
        "components.interfaces.block": ("Block", "Continuous", "NoState", "Sampled", "block"),
        "components.interfaces.buses": (
            "Actuation",
            "Motion",
            "ObstacleList",
            "Plan",
            "Solver",
            "SolverStatus",
            "Tyre",
            "VehicleState",
            "Waypoints",
        ),
        "components.interfaces.problem": ("Problem", "RequestError"),
        "components.interfaces.quantity": ("boolean", "enumeration", "integer", "quantity"),
        "components.interfaces.record": ("record",),
        "components.interfaces.socket": ("BusTraits", "Position", "Reading", "Socket"),
        "components.interfaces.sockets": (
            "CONTROLLER",
            "PLANT",
            "SOCKETS",
            "TRAFFIC",
            "ControllerInputs",
            "ControllerOutputs",
            "PlantInputs",
            "PlantOutputs",
            "TrafficInputs",
            "TrafficOutputs",
            "add_socket",
            "remove_socket",
            "standard_wiring",
        ),
        "components.traffic.dense_traffic": ("DenseTraffic",),
        "components.traffic.empty_road": ("EmptyRoad",),
        "components.traffic.ramp_traffic": ("RampTraffic",),
        "components.vehicle.bicycle": ("Bicycle",),
        "components.vehicle.bicycle_saturated": ("BicycleSaturated",),
        "components.vehicle.commonroad_mb": ("CommonroadMb",),
        "components.vehicle.commonroad_st": ("CommonroadSt",),
        "components.vehicle.stationary": ("Stationary",),
    },
)
