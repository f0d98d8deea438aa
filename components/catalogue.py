"""The catalogue of blocks: those that come with macrostep, and those that are added while a program runs."""

from __future__ import annotations

from collections.abc import Mapping
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
from components.interfaces.problem import refuse
from components.traffic.dense_traffic import DenseTraffic
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
    DenseTraffic,
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
"""The blocks that come with macrostep and can be used here."""

_by_name: dict[str, type[Block[Any, Any, Any]]] = {block.name: block for block in CATALOGUE}

BLOCKS: Final[Mapping[str, type[Block[Any, Any, Any]]]] = MappingProxyType(_by_name)
"""All blocks by name: those of `CATALOGUE`, and those that `add_block` has added."""

EXTRAS: Final = MappingProxyType({block.name: "commonroad" for block in (CommonroadSt, CommonroadMb)})
"""Blocks that are in the catalogue only when an extra of macrostep is installed, with the name of the extra."""


def add_block(block: type[Block[Any, Any, Any]]) -> None:
    """Add a block to `BLOCKS`, so that scenarios and the command can name it in this process.

    Args:
        block: A class with the decorator `block`; its socket may be one of your own.

    Raises:
        RequestError: `BLOCKS` has another block of that name.
    """
    if _by_name.setdefault(block.name, block) is not block:
        raise refuse(f"block `{block.name}`", "another block of that name", "a name that is free")


def remove_block(name: str) -> None:
    """Remove a block that `add_block` has added; another, or one that is not there, stays as it is.

    Args:
        name: The block's name, such as `my_vehicle`.
    """
    if name not in {block.name for block in CATALOGUE}:
        _by_name.pop(name, None)
