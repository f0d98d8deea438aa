"""A system of a person's own, run as a scenario is (`own_system.py`)."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any, final

import pandas as pd
import pytest

from components import (
    BLOCKS,
    PLANT,
    Continuous,
    Motion,
    PlantInputs,
    PlantOutputs,
    VehicleState,
    block,
    quantity,
    record,
    standard_wiring,
)
from components.interfaces.problem import RequestError
from orchestrator import Fmu, Options, Simulation, System, block_source, load, run, simulate
from orchestrator.own_system import as_scenario
from orchestrator.results.run_folder import FIGURES, RECORDING, SIGNALS, SYSTEM


@record
class OwnOutputs(PlantOutputs):
    """What it shows."""

    motion: Motion


@final
@block(PLANT)
class PointMass(Continuous[PlantInputs, VehicleState, OwnOutputs]):
    """A point mass that moves along the road; the wheels turn nothing."""

    m: float = quantity("kg", "mass", min=1)
    v_x_start: float = quantity("m/s", "speed at the start")

    def start(self) -> VehicleState:
        return VehicleState(x=0.0, y=0.0, psi=0.0, v_x=self.v_x_start, v_y=0.0, r=0.0)

    def derivative(self, x: VehicleState, u: PlantInputs) -> VehicleState:
        still = 0.0 * x.y
        return VehicleState(x=x.v_x, y=still, psi=still, v_x=u.actuation.T_r / self.m, v_y=still, r=still)

    def output(self, x: VehicleState, u: PlantInputs) -> OwnOutputs:
        return OwnOutputs(state=x, motion=Motion(a_x=u.actuation.T_r / self.m, a_y=0.0 * x.y, r_dot=0.0 * x.y))


def others() -> dict[str, Any]:
    return dict(load("idle", Options(mode="blocks")).system.units)


@pytest.fixture
def system() -> System:
    return System({**others(), "plant": block_source(PointMass(m=2000.0, v_x_start=10.0))}, standard_wiring())


def test_a_system_of_ones_own_gets_what_a_scenario_gets(system, tmp_path):
    finished = run(system, until=1.0, name="mine", out=tmp_path / "r")
    folder = finished.folder
    assert finished.ended is None
    for name in (SIGNALS, RECORDING, SYSTEM, f"{FIGURES}/trajectory.png", f"{FIGURES}/speed.png"):
        assert (folder / name).is_file(), name
    summary = json.loads((folder / "summary.json").read_text("utf-8"))
    assert summary["scenario"] == "mine"
    assert summary["metrics"]["v_x_max"] == 10.0
    assert summary["verdicts"]["inside_road"] is True
    assert summary["parameters"]["plant.m"] == {"value": 2000.0, "unit": "kg", "source": "Python"}
    assert summary["parameters"]["scene.y_left"]["unit"] == "m"
    frame = pd.read_parquet(folder / SIGNALS)
    pd.testing.assert_frame_equal(frame, simulate(system, h=0.1, until=1.0), check_exact=True)
    assert (
        "no scene is given: the road and the size of the vehicle are those of the scenario `static`" in finished.notes
    )


def test_its_folder_alone_repeats_the_run_in_a_process_that_does_not_know_the_block(system, tmp_path):
    run(system, until=1.0, out=tmp_path / "r", figures=False)
    command = [sys.executable, "-m", "orchestrator.command.main", "run", "r", "--out", "again"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    first, again = (pd.read_parquet(tmp_path / name / SIGNALS) for name in ("r", "again"))
    pd.testing.assert_frame_equal(first, again, check_exact=True)


def test_without_a_compiler_it_runs_in_this_process_and_that_is_told(system, tmp_path, monkeypatch):
    monkeypatch.setattr("orchestrator.own_system.find_compiler", lambda: None)
    finished = run(system, until=0.5, out=tmp_path / "r", figures=False)
    told = "plant: `point_mass` runs in this process, because there is no C compiler; its folder alone repeats no run"
    assert told in finished.notes
    assert (tmp_path / "r" / RECORDING).is_file()
    assert "point_mass" not in BLOCKS


def test_a_scene_is_taken_and_a_scenario_is_changed(system, tmp_path):
    idle = load("idle", Options(mode="blocks"))
    wide = run(system, until=0.2, scene=idle.scene, out=tmp_path / "a", figures=False)
    assert not [note for note in wide.notes if "scene" in note]
    changed = run(idle, until=0.3, name="short", out=str(tmp_path / "b"), figures=False)
    assert changed.summary["experiment"]["ticks"] == 4
    assert changed.summary["scenario"] == "short"


def test_units_of_other_names_fill_no_socket(tmp_path):
    units = {"car": block_source(PointMass(m=2000.0, v_x_start=10.0))}
    system = System(units, {}, held={"car.actuation.T_r": 0.0, "car.actuation.delta_f": 0.0})
    finished = run(system, until=0.2, out=tmp_path / "r")
    assert finished.summary["metrics"] == {}
    assert len(pd.read_parquet(tmp_path / "r" / SIGNALS)) == 3


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "run: until: found no stop time; valid: a number of seconds. Write run(system, until=10.0)."),
        ({"until": "3"}, "run: until: found `'3'` (str); valid: float or None"),
        ({"until": 0.25}, "stop time: found 0.25 s; valid: a whole number of steps of 0.1 s. Try 0.2 s."),
        ({"until": 1.0, "name": "a/b"}, "run: name: found `a/b`; valid: a name without folders"),
        ({"until": 1.0, "algorithm": "gauss"}, "algorithm: found `gauss`; valid: clocked, jacobi, sequential"),
        ({"until": 1.0, "scene": {"y_left": 3}}, "run: scene: found `{'y_left': 3}` (dict); valid: Scene or None"),
    ],
)
def test_wrong_arguments_are_told_in_four_parts_and_nothing_is_written(system, tmp_path, given, message):
    with pytest.raises(RequestError) as error:
        run(system, **given, out=tmp_path / "r")
    assert str(error.value).startswith(message)
    assert not (tmp_path / "r").exists()


def test_what_is_no_system_is_told_with_how_to_make_one():
    with pytest.raises(RequestError, match=r"run: system: found `'static'` \(str\); valid: System or Scenario"):
        run("static", until=1.0)
    wrong = r"System: units\['plant'\]: found `'x.fmu'` \(str\); valid: UnitSource. Make one of a file with Fmu\(path\)"
    with pytest.raises(RequestError, match=wrong):
        System({"plant": "x.fmu"}, {})
    with pytest.raises(RequestError, match=r"Simulation: system: found `Scenario.*Write load"):
        Simulation(load("idle", Options(mode="blocks")), h=0.1, until=1.0)
    with pytest.raises(RequestError, match=r"replacements: found the unknown socket `plnt`.*Did you mean `plant`"):
        load("static", Options(mode="blocks", replacements={"plnt": "bicycle"}))
    with pytest.raises(RequestError, match=r"controller.egoo: found unconverted, but without a connection"):
        System(others(), standard_wiring(), unconverted={"controller.egoo"})


def test_a_path_may_be_a_text_or_a_path(system, tmp_path):
    made = as_scenario(system, {"until": 1.0}, progress=__import__("orchestrator").SILENT)
    file = made.system.units["plant"].path
    assert Fmu(str(file)) == Fmu(file)
