"""`static` with every plant there is: our blocks, the vehicles of others, Modelica, and FMUs made by other tools."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from components import BLOCKS
from fmus.modelica.flat import library
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator import SILENT, Options, RequestError, Scenario, load, metrics, shown, simulate
from orchestrator.exchange.export import Targets, write
from tests.orchestrator.foreign import CART, CART_MAPPING

README = (Path(__file__).parents[2] / "fmus" / "README.md").read_text(encoding="utf-8")
BICYCLE = str(library() / "Examples" / "PaperBicycle.mo")
OURS = [
    name for name, block in BLOCKS.items() if block.socket.name == "plant" and name != "stationary"
]  # it does not move


def block_of_readme(language: str, name: str) -> str:
    """The README's only code block of a language in which a class is defined."""
    (text,) = [t for t in re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL) if re.search(rf"\b{name}\b", t)]
    return text


def made_with(tool: str, script: Path) -> str:
    """The FMU that a tool makes of a script, as its documentation says."""
    command = [sys.executable, "-m", tool, "build", "-f", str(script), "-d", str(script.parent)]
    subprocess.run(command, check=True, capture_output=True)
    (fmu,) = script.parent.glob("*.fmu")
    return str(fmu)


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """Plants in files, by what they are made with."""
    folders = {name: tmp_path_factory.mktemp(name) for name in ("pythonfmu3", "pythonfmu", "modelica")}
    script = folders["pythonfmu3"] / "my_vehicle.py"
    script.write_text(block_of_readme("python", "Fmi3Slave"), encoding="utf-8")
    double = folders["pythonfmu"] / "kinematic_fmi2.py"
    double.write_bytes((Path(__file__).parent / "kinematic_fmi2.py").read_bytes())
    model = folders["modelica"] / "MyVehicle.mo"
    model.write_text(block_of_readme("modelica", "MyVehicle"), encoding="utf-8")
    mapping = folders["modelica"] / "Cart.plant.toml"
    mapping.with_name("Cart.mo").write_text(CART, encoding="utf-8")
    mapping.write_text(CART_MAPPING, encoding="utf-8")
    return {
        "pythonfmu3": made_with("pythonfmu3", script),
        "pythonfmu": made_with("pythonfmu", double),
        "modelica": str(model),
        "modelica mapped": str(mapping),
        "modelica bicycle": BICYCLE,
    }


def drive(plant: str, mode="blocks", **options):
    made = load("static", Options(mode=mode, replacements={"plant": plant}, **options))
    return made, simulate(made.system, h=made.h, until=made.until)


def without_contact(made, frame) -> dict[str, float]:
    """The metrics of a run that drives the lane change and touches nothing."""
    found = metrics.compute(frame, shown(made.system), made.scene)
    assert metrics.verdicts(found)["no_contact"]
    assert frame["plant.state.x"].iloc[-1] > 110
    assert frame["plant.state.y"].max() > 3
    return found


@pytest.mark.parametrize("plant", OURS)
def test_static_at_10_m_per_s_without_contact(plant):
    without_contact(*drive(plant))


@pytest.mark.parametrize("plant", ["pythonfmu3", "pythonfmu", "modelica", "modelica mapped", "modelica bicycle"])
def test_static_with_plants_in_files_without_contact(foreign, plant):
    without_contact(*drive(foreign[plant]))


@pytest.mark.parametrize("plant", ["commonroad_st", "commonroad_mb"])
def test_the_papers_controller_keeps_another_vehicle_on_the_road(plant):
    found = without_contact(*drive(plant))
    assert found["gap_edge"] > 0.5
    assert found["path_error_max"] < 0.5


@pytest.mark.parametrize("mode", ["blocks", *WRITTEN_VERSIONS])
def test_the_bicycle_in_modelica_is_ours_over_the_whole_run(built_fmus, mode):
    _, ours = drive("bicycle", mode)
    made, theirs = drive(BICYCLE, mode)
    assert made.remarks == ()
    assert sorted(theirs.columns) == sorted(ours.columns)
    np.testing.assert_allclose(theirs[ours.columns].to_numpy(float), ours.to_numpy(float), rtol=0, atol=1e-9)


def test_both_versions_of_the_same_python_vehicle_drive_alike(foreign):
    _, third = drive(foreign["pythonfmu3"])
    _, second = drive(foreign["pythonfmu"])
    shown = [c for c in third.columns if c.startswith("plant.")]
    assert third[shown].equals(second[shown])


def test_a_parameter_of_a_modelica_plant_can_be_set(foreign):
    _, heavy = drive(foreign["modelica"], settings=["plant.m=4000.0"])
    _, light = drive(foreign["modelica"])
    assert (heavy["plant.state.v_x"] - light["plant.state.v_x"]).abs().max() > 0.01


FLAT = {
    "MyVehicle": "FlatVehicle",
    "extends MacroStep.Interfaces.Plant;": (
        'input Real steer(unit = "rad"); input Real T_r; output Real x(unit = "m"); output Real y; output Real psi;'
        ' output Real speed(unit = "m/s"); output Real drift(unit = "m/s"); output Real yaw_rate(unit = "rad/s");'
    ),
    "actuation.delta_f": "steer",
    "actuation.T_r": "T_r",
    "state.x": "x",
    "state.y": "y",
    "state.psi": "psi",
    "state.v_x": "speed",
    "state.v_y": "drift",
    "state.r": "yaw_rate",
}
FLAT_MAPPING = """fmu = "Flat.mo:FlatVehicle"
[state]
v_x = "speed"
v_y = "drift"
r = "yaw_rate"
[actuation]
delta_f = "steer"
"""


def test_a_modelica_plant_with_flat_names_behind_a_mapping_drives_as_with_those_of_its_socket(foreign, tmp_path):
    flat = Path(foreign["modelica"]).read_text("utf-8")
    for ours, theirs in FLAT.items():
        assert ours in flat
        flat = re.sub(rf"{re.escape(ours)}(?!\w)", theirs, flat)
    (tmp_path / "Flat.mo").write_text(flat, encoding="utf-8")
    (tmp_path / "flat.toml").write_text(FLAT_MAPPING, encoding="utf-8")
    _, expected = drive(foreign["modelica"], settings=["plant.m=1900.0"])
    made, found = drive(str(tmp_path / "flat.toml"), settings=["plant.m=1900.0"])
    assert made.system.units["plant"].fmu.named_as == f"{tmp_path}/Flat.mo:FlatVehicle"
    assert sorted(found.columns) == sorted(expected.columns)
    np.testing.assert_allclose(
        found[expected.columns].to_numpy(float), expected.to_numpy(float), rtol=1e-12, atol=1e-12
    )


def test_the_readmes_vehicle_has_30_lines():
    assert len(block_of_readme("python", "Fmi3Slave").splitlines()) == 30


def test_a_modelica_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(RequestError) as refused:
        drive(str(tmp_path / "none.mo"))
    assert str(refused.value) == f"{tmp_path / 'none.mo'}: found no such file; valid: a Modelica file (.mo)"


def test_a_block_whose_extra_is_missing_says_what_to_install(monkeypatch):
    kept = {name: block for name, block in BLOCKS.items() if not name.startswith("commonroad")}
    monkeypatch.setattr("orchestrator.scenario.catalogue.BLOCKS", kept)
    with pytest.raises(RequestError) as refused:
        drive("commonroad_st")
    assert str(refused.value) == (
        "--plant: found `commonroad_st` without its extra; valid: bicycle, bicycle_saturated, stationary. "
        "Install macrostep[commonroad]."
    )


def left(plant: str, version: Version, folder: Path) -> tuple[Scenario, Path, Path]:
    """A run with a plant, and what leaves of it for other tools: an SSP and a container."""
    asked = Options(mode=version, stop_time=4.0, replacements={"plant": plant, "controller": "lqr"})
    targets = Targets(folder / "a.ssp", folder / "a.fmu")
    write("static", asked, targets, SILENT)
    return load("static", asked), folder / "a.ssp", folder / "a.fmu"


@pytest.mark.parametrize(("plant", "version"), [("pythonfmu3", Version.FMI3), ("pythonfmu", Version.FMI2)])
def test_a_plant_that_declares_no_dependencies_leaves_and_comes_back(foreign, tmp_path, plant, version):
    """Its socket says here that inputs act through the step; in what left, an annotation says so."""
    made, exported, container = left(foreign[plant], version, tmp_path)
    assert made.system.units["plant"].fmu.interface.undeclared
    back = load(exported)
    (told,) = [r for r in back.remarks if "through a step" in r]
    assert told.startswith("plant: ")
    assert told.endswith(" follow the inputs through a step only, as the file says, whatever the FMU declares")
    expected, found = (simulate(one.system, h=one.h, until=one.until) for one in (made, back))
    kept = ["controller.actuation.delta_f", "controller.actuation.T_r", "traffic.obstacles.x[1]"]
    pd.testing.assert_frame_equal(found[kept], expected[kept], check_exact=True)
    assert np.ptp(expected["controller.actuation.delta_f"]) > 1e-3
    one = load(container, Options(stop_time=4.0))
    rows = simulate(one.system, h=one.h, until=one.until)["fmu.controller.actuation.delta_f"]
    assert rows[1:].to_numpy() == pytest.approx(expected["controller.actuation.delta_f"][:-1].to_numpy(), abs=1e-9)
