"""What the tests of the blocks share: blocks with the product's own parameter values, and short ways to say inputs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from components import BLOCKS
from components.interfaces.block import Block
from components.interfaces.buses import SLOTS, ObstacleList, VehicleState
from tests.components.parameter_sets import block_values


@pytest.fixture(scope="session")
def make() -> Callable[..., Any]:
    """A block of the catalogue by name, with its default parameter set and the given changes."""

    def made(name: str, **changes: Any) -> Block[Any, Any, Any]:
        return BLOCKS[name](**{**block_values(name), **changes})

    return made


@pytest.fixture(scope="session")
def vehicle() -> Callable[..., VehicleState]:
    """A vehicle state; what is not said is straight running at 10 m/s from the origin."""

    def state(**values: float) -> VehicleState:
        return VehicleState(**{"x": 0.0, "y": 0.0, "psi": 0.0, "v_x": 10.0, "v_y": 0.0, "r": 0.0, **values})

    return state


@pytest.fixture(scope="session")
def obstacles() -> Callable[..., ObstacleList]:
    """The obstacles bus with the given obstacles (dictionaries) in its first slots, of 4.6 m by 1.8 m."""

    def listed(*given: dict[str, float]) -> ObstacleList:
        fields = {name: np.zeros(SLOTS) for name in ("valid", "x", "y", "psi", "v", "length", "width")}
        for i, obstacle in enumerate(given):
            for name, value in {"valid": 1.0, "length": 4.6, "width": 1.8, **obstacle}.items():
                fields[name][i] = value
        return ObstacleList(id=np.arange(1.0, SLOTS + 1), **fields)

    return listed
