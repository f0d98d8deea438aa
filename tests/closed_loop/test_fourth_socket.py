"""A socket is data: a fourth one, added here and nowhere else, works in scenarios, FMUs, SSP and the command."""

from __future__ import annotations

import json
from pathlib import Path
from typing import final

import numpy as np
import pandas as pd
import pytest
from pandas.testing import assert_frame_equal

from components import (
    BusTraits,
    NoState,
    ObstacleList,
    Sampled,
    Socket,
    VehicleState,
    add_block,
    add_socket,
    block,
    quantity,
    record,
    remove_block,
    remove_socket,
)
from fmus import Version, build
from orchestrator import Options, RequestError, load, simulate
from orchestrator.scenario.catalogue import built_folder
from tests.orchestrator.foreign import relabelled


@record
class Attention:
    """What the driver attends to."""

    angle: float = quantity("rad", "direction of the gaze, to the left")
    distance: float = quantity("m", "distance to what lies in the first slot, along the road")


@record
class DriverInputs:
    """What a driver sees."""

    ego: VehicleState
    obstacles: ObstacleList


@record
class DriverOutputs:
    """What every driver shows."""

    attention: Attention


DRIVER = Socket(
    name="driver",
    inputs={"ego": VehicleState, "obstacles": ObstacleList},
    outputs={"attention": Attention},
    traits={"ego": BusTraits(driven_by="plant.state"), "obstacles": BusTraits(driven_by="traffic.obstacles")},
)


@final
@block(DRIVER)
class Novice(Sampled[DriverInputs, NoState, DriverOutputs]):
    """Looks where the vehicle turns, and at the first obstacle."""

    k: float = quantity("s", "time ahead for which the driver looks", min=0)

    def start(self):
        return NoState()

    def sample(self, x, u):
        distance = u.obstacles.x[0] - u.ego.x
        return x, DriverOutputs(attention=Attention(angle=self.k * u.ego.r, distance=distance))


TABLE = """
[driver]
block = "novice"
[driver.parameters]
k = { value = 0.5, unit = "s", source = "this test" }
"""
SCENARIOS = Path(__file__).parents[2] / "orchestrator" / "scenarios"


@pytest.fixture(autouse=True)
def driver():
    """The socket and its block are known while a test runs."""
    add_socket(DRIVER)
    add_block(Novice)
    yield
    remove_socket("driver")
    remove_block("novice")
    for fmu in built_folder().glob("*/novice.fmu"):
        fmu.unlink()  # other tests count what is there


@pytest.fixture
def scenario(in_tmp_path):
    """The static lane change with somebody at the wheel."""
    path = in_tmp_path / "driven.toml"
    path.write_text((SCENARIOS / "static.toml").read_text(encoding="utf-8") + TABLE, encoding="utf-8")
    return path


def rows(folder):
    return pd.read_parquet(folder / "signals.parquet")


def others(frame):
    return frame[[name for name in frame if not name.startswith("driver.")]]


@pytest.mark.parametrize("mode", [("--blocks",), ("--fmi", "2"), ("--fmi", "3")], ids=" ".join)
def test_a_scenario_with_a_driver_runs(scenario, macrostep, mode):
    code, said, err = macrostep("run", scenario, *mode, "--set", "driver.k=2.0", "--out", "run")
    assert (code, err.count("macrostep:")) == (0, 0), (said, err)
    frame = rows(scenario.parent / "run")
    assert np.allclose(frame["driver.attention.angle"], 2.0 * frame["plant.state.r"], rtol=0, atol=1e-12)
    assert frame["driver.attention.distance"][0] == frame["traffic.obstacles.x[1]"][0] - frame["plant.state.x"][0]
    summary = json.loads((scenario.parent / "run" / "summary.json").read_text())
    assert summary["units"]["driver"]["socket"] == "driver"
    assert summary["parameters"]["driver.k"] == {"value": 2.0, "unit": "s", "source": "--set"}
    assert "drive" not in summary["metrics"]
    without = load("static", Options(mode="blocks"))
    assert_frame_equal(others(frame), simulate(without.system, h=without.h, until=without.until), rtol=0, atol=1e-9)


def test_the_run_is_repeated_from_its_folder(scenario, macrostep, without_pictures):
    assert macrostep("run", scenario, "--blocks", "--stop-time", "1", "--out", "first")[0] == 0
    assert macrostep("run", "first", "--out", "second")[0] == 0
    assert_frame_equal(rows(scenario.parent / "first"), rows(scenario.parent / "second"), rtol=0, atol=0)
    assert load("first").system.sockets["driver"] is DRIVER


def test_the_command_has_an_option_for_it(in_tmp_path, macrostep, without_pictures):
    code, said, err = macrostep(
        "run", "static", "--blocks", "--driver", "novice", "--set", "driver.k=1.0", "--stop-time", "1", "--out", "run"
    )
    assert (code, err) == (0, ""), said
    assert "driver.attention.angle" in rows(in_tmp_path / "run")
    code, said, _ = macrostep("run", "--help")
    assert code == 0
    assert "Another driver" in said


def test_an_fmu_of_another_maker_fits_it(in_tmp_path, macrostep, without_pictures):
    fmu = build(Novice, Version.FMI2, {"k": 0.5}, in_tmp_path).path
    code, said, _ = macrostep("check", fmu, "--socket", "driver")
    assert code == 0
    assert "socket driver: fits as it is" in said
    assert macrostep("run", "static", "--blocks", "--driver", fmu, "--stop-time", "1", "--out", "run")[0] == 0
    frame = rows(in_tmp_path / "run")
    assert np.allclose(frame["driver.attention.angle"], 0.5 * frame["plant.state.r"], rtol=0, atol=1e-12)


def test_structures_of_other_makers_are_found_under_its_name(tmp_path, built_fmus):
    names = {f"attention.{leaf}": f"driver_attention_{leaf}" for leaf in ("angle", "distance")}
    fmu = relabelled(build(Novice, Version.FMI2, {"k": 0.5}, tmp_path).path, tmp_path / "theirs.fmu", names)
    options = Options(mode="blocks", replacements={"driver": str(fmu)}, stop_time=1.0)
    assert "attention.angle" in {v.name for v in load("static", options).system.units["driver"].interface.outputs}


def test_the_known_names_stand_in_messages(scenario):
    with pytest.raises(RequestError) as wrong:
        load(str(scenario), Options(mode="blocks", replacements={"driver": "bicycle"}))
    assert str(wrong.value) == "--driver: found `bicycle`, a block of the socket `plant`; valid: novice"
    with pytest.raises(RequestError) as wrong:
        load(str(scenario), Options(mode="blocks", settings=["drivers.k=1"]))
    assert str(wrong.value) == (
        "--set drivers.k=1: found the unknown unit `drivers`; valid: controller, driver, plant, scene, traffic"
    )
