"""What is simulated. `BLOCKS` is the catalogue of all blocks by name."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any, Final

from components.controller.coast import Coast
from components.controller.constrained_mpc import ConstrainedMpc
from components.controller.lqr import Lqr
from components.controller.mpc import Mpc
from components.controller.mpc_external import MpcInteriorPoint, MpcSqp
from components.controller.pure_pursuit import PurePursuit
from components.controller.stanley import Stanley
from components.controller.two_level_mp import TwoLevelMp
from components.interfaces.block import Block
from components.traffic.empty_road import EmptyRoad
from components.traffic.ramp_traffic import RampTraffic
from components.vehicle.bicycle import Bicycle
from components.vehicle.bicycle_saturated import BicycleSaturated
from components.vehicle.commonroad import installed
from components.vehicle.commonroad_mb import CommonroadMb
from components.vehicle.commonroad_st import CommonroadSt
from components.vehicle.stationary import Stationary

CATALOGUE: Final[tuple[type[Block[Any, Any, Any]], ...]] = (
    Bicycle,
    BicycleSaturated,
    Stationary,
    *((CommonroadSt, CommonroadMb) if installed() else ()),
    RampTraffic,
    EmptyRoad,
    Mpc,
    MpcSqp,
    MpcInteriorPoint,
    ConstrainedMpc,
    Lqr,
    Stanley,
    PurePursuit,
    TwoLevelMp,
    Coast,
)
BLOCKS: Final = MappingProxyType({kind.name: kind for kind in CATALOGUE})
EXTRAS: Final = MappingProxyType({kind.name: "commonroad" for kind in (CommonroadSt, CommonroadMb)})
"""Blocks that are in the catalogue only when an extra of macrostep is installed, with the name of the extra."""
