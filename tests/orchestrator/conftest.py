"""What these tests share: run folders, and where pictures can be drawn."""

from __future__ import annotations

from pathlib import Path
from shutil import copytree

import numpy as np
import pytest

from orchestrator.recording.stream import RerunStream
from orchestrator.results.parquet import write_signals
from orchestrator.results.run_folder import write_system
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation

DRIVERS = Path("/usr/share/vulkan/icd.d")


@pytest.fixture(scope="session")
def kept_run():
    """Makes run folders as a run leaves them, with `recording.rrd` and `signals.parquet` and no more than needed."""

    def make(folder: Path, name: str = "static", settings: tuple[str, ...] = (), until: float | None = None) -> Path:
        scenario = prepare(name, Options(mode="blocks", settings=settings))
        with Simulation(scenario.system, h=scenario.h, until=until or scenario.until) as simulation:
            simulation.run()
            frame = simulation.frame()
        folder.mkdir(parents=True)
        write_system(scenario, folder)
        write_signals(frame, scenario, folder / "signals.parquet")
        stream = RerunStream(
            folder / "recording.rrd", scenario.system, scenario.scene, name=folder.name, grid=scenario.grid, about={}
        )
        stream.log(frame, np.zeros(len(frame)))
        stream.close()
        return folder

    return make


@pytest.fixture(scope="session")
def graphics():
    """Skips where there is no Vulkan driver at all."""
    if not list(DRIVERS.glob("*.json")):
        pytest.skip("no Vulkan driver: apt-get install mesa-vulkan-drivers libvulkan1")


@pytest.fixture(scope="session")
def whole(kept_run, tmp_path_factory):
    """The folder of a run of 2 s."""
    return kept_run(tmp_path_factory.mktemp("runs") / "static-1", until=2.0)


@pytest.fixture
def run(whole, tmp_path):
    """A copy of it that may be damaged."""
    return copytree(whole, tmp_path / "static-1")
