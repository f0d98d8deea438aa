"""What the tests of FMUs share: start values for every block, and all FMUs built once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from components import BLOCKS
from components.interfaces.block import Block
from components.interfaces.progress import SILENT
from fmus.export.build import build_all
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator.scenario.catalogue import default_values
from tests.fmus.fmu_driver import FmuDriver

BICYCLE = {
    "m": 2000.0,
    "I_z": 1300.0,
    "l_f": 1.2,
    "l_r": 1.05,
    "C_alpha_f": 12000.0,
    "C_alpha_r": 12000.0,
    "R_w": 0.3,
    "mu": 0.5,
    "g": 9.81,
    "v_x_start": 10.0,
    **dict.fromkeys(("x_start", "y_start", "psi_start", "v_y_start", "r_start"), 0.0),
}
RAMP_TRAFFIC = {
    "valid": [True, True, True, False, False, False, False, False],
    "x_start": [100.0, 40.0, -10.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "y_start": [0.0, 3.6, 3.6, 0.0, 0.0, 0.0, 0.0, 0.0],
    "psi_start": [0.0, 0.1, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "v_start": [5.0, 12.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "v_final": [10.0, 4.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "a": [2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    "length": [4.6] * 8,
    "width": [1.8] * 8,
}


OWN: Mapping[str, Mapping[str, Any]] = {"bicycle": BICYCLE, "ramp_traffic": RAMP_TRAFFIC}


def start_values(block: type[Block[Any, Any, Any]]) -> Mapping[str, Any]:
    """Start values for a block's parameters: our own above, otherwise those of its parameter file."""
    return OWN.get(block.name) or default_values(block)


@pytest.fixture(scope="session")
def start_of() -> Callable[[str], dict[str, Any]]:
    """Start values of a block by its name, as a copy."""
    return lambda name: dict(start_values(BLOCKS[name]))


@pytest.fixture(scope="session")
def built(built_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Mapping[tuple[str, Version], Path]:
    """All blocks of the catalogue in both versions, by name and version; those with start values of our own anew."""
    requests = [(BLOCKS[name], version, OWN[name]) for name in OWN for version in WRITTEN_VERSIONS]
    made = build_all(requests, tmp_path_factory.mktemp("built"), SILENT)
    found = {
        (n, v): built_fmus / f"fmi{v}" / f"{n}.fmu" for n, b in BLOCKS.items() if b.native for v in WRITTEN_VERSIONS
    }
    return found | {(block.name, version): b.path for (block, version, _), b in zip(requests, made, strict=True)}


@pytest.fixture
def drive(built: Mapping[tuple[str, Version], Path]) -> Iterator[Callable[..., FmuDriver]]:
    """A new instance of an FMU by name and version, closed after the test."""
    drivers: list[FmuDriver] = []

    def open_one(name: str, version: Version, *, event_mode: bool = False) -> FmuDriver:
        drivers.append(FmuDriver(built[name, version], event_mode=event_mode))
        return drivers[-1]

    yield open_one
    for driver in drivers:
        driver.close()
