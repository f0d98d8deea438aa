"""FMUs of other makers in the closed loop: whatever they call their signals, the run is that of our own plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from lxml import etree
from pythonfmu import FmuBuilder

from components.interfaces.problem import RequestError
from components.interfaces.sockets import PLANT
from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator.mapping.mapped import Mapped, mapped
from orchestrator.results import summary
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from tests.fmus.foreign import copied, entries
from tests.orchestrator import foreign

STATE = ("x", "y", "psi", "v_x", "v_y", "r")


def prepared(plant, controller="lqr", **options):
    replacements = {"plant": str(plant), "controller": controller, **options}
    return prepare("static", Options(mode="blocks", stop_time=6.0, replacements=replacements))


def run(made):
    return simulate(made.system, h=made.h, until=made.until)


@pytest.fixture(scope="module")
def python_fmu(tmp_path_factory):
    """A plant made with pythonfmu."""
    script = Path(__file__).with_name("python_car.py")
    return FmuBuilder.build_FMU(script, dest=tmp_path_factory.mktemp("python"))


@pytest.fixture(scope="module")
def own():
    """The same run with our own plant."""
    return run(prepared("bicycle"))


def assert_same(found, own, tolerance=1e-9):
    columns = [c for c in own.columns if c.startswith(("plant.state.", "controller.actuation.", "traffic."))]
    for column in columns:
        scale = 1 + np.abs(own[column].to_numpy(float)).max()
        assert found[column].to_numpy(float) / scale == pytest.approx(
            own[column].to_numpy(float) / scale, abs=tolerance
        ), column
    assert own["plant.state.y"].abs().max() > 2, "there was a lane change"


@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids="fmi{}".format)
def test_km_per_hour_degrees_y_to_the_right_and_the_rear_axle(tmp_path, own, version):
    made = prepared(foreign.right_handed_mapping(tmp_path, version))
    assert made.remarks == ()
    found = run(made)
    assert_same(found, own)
    assert (found["plant.car.engine"] == 42).all()
    assert not any(column.startswith("plant.car.east") for column in found)


RATE = """
fmu = "{fmu}"
[state]
velocity = "speed_and_slip"
v = "y.v"
beta = "y.beta"
[actuation]
delta_f = {{ variable = "u.steer_rate", as = "steering_rate"{angle} }}
[[actuation.T_r]]
variable = "u.accel"
as = "acceleration"
R_w = {{ value = 30, unit = "cm" }}
m = {{ value = 2, unit = "t" }}
"""


def rate_car(folder, angle=""):
    """The mapping of the car that is steered by a rate; `angle` is more about its steering."""
    path = folder / "rate.toml"
    path.write_text(RATE.format(fmu=foreign.made(foreign.RateCar, folder).name, angle=angle))
    return path


@pytest.mark.parametrize("angle", ["", ', angle = "y.delta"'], ids=["kept", "shown"])
def test_steering_rate_and_acceleration_inputs(tmp_path, own, angle):
    found = run(prepared(rate_car(tmp_path, angle)))
    assert_same(found, own)
    assert found["plant.y.delta"].to_numpy()[1:] == pytest.approx(own["controller.actuation.delta_f"].to_numpy()[:-1])


def test_a_steering_rate_is_limited(tmp_path):
    made = prepared(rate_car(tmp_path, ', limit = { value = 1, unit = "deg/s" }'))
    delta = run(made)["plant.y.delta"].to_numpy()
    assert np.abs(np.diff(delta)).max() == pytest.approx(np.deg2rad(0.1))


def renamed(spelling):
    return {f"{bus}.{leaf}": spelling(bus, leaf) for bus, leaves in LEAVES.items() for leaf in leaves}


LEAVES = {"state": STATE, "actuation": ("delta_f", "T_r")}
SPELLINGS = {
    "underscores": lambda bus, leaf: f"{bus}_{leaf}",
    "simulink": lambda bus, leaf: f"{'In' if bus == 'actuation' else 'Out'}_{bus}.{leaf}",
    "bus objects": lambda bus, leaf: f"{bus}Bus.{leaf.replace('_', '')}",
    "flat": lambda bus, leaf: leaf,
}


@pytest.mark.parametrize("spelling", list(SPELLINGS))
@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids="fmi{}".format)
def test_other_spellings_need_no_file(tmp_path, built_fmus, own, spelling, version):
    source = built_fmus / f"fmi{version}" / "bicycle.fmu"
    units = {"state.v_x": None, "actuation.T_r": None}
    fmu = foreign.relabelled(source, tmp_path / "theirs.fmu", renamed(SPELLINGS[spelling]), units)
    made = prepared(fmu)
    assert len(made.remarks) == 8
    assert "without a unit, taken as m/s" in "".join(made.remarks)
    assert_same(run(made), own, 1e-12)
    assert made.system.units["plant"].interface.feedthrough.shape == (15, 2)


def test_an_fmu_that_does_not_declare_its_dependencies_still_steps_with_ours(tmp_path, built_fmus, own):
    fmu = foreign.relabelled(built_fmus / "fmi2" / "bicycle.fmu", tmp_path / "theirs.fmu", silent=True)
    traffic = foreign.relabelled(built_fmus / "fmi2" / "ramp_traffic.fmu", tmp_path / "cars.fmu", silent=True)
    made = prepared(fmu, traffic=str(traffic))
    assert_same(run(made), own)


def flat_obstacles(name):
    bus, _, rest = name.partition(".")
    leaf, _, index = rest.partition("[")
    return f"{bus}[{index[:-1]}].{leaf}"


def test_arrays_of_structures_in_fmi_2(tmp_path, built_fmus, own):
    source = built_fmus / "fmi2" / "ramp_traffic.fmu"
    outputs = [e for v in Fmu(source).interface.outputs for e in v.elements]
    fmu = foreign.relabelled(source, tmp_path / "cars.fmu", {name: flat_obstacles(name) for name in outputs})
    made = prepared("bicycle", traffic=str(fmu))
    assert isinstance(made.system.units["traffic"], Mapped)
    assert_same(run(made), own, 1e-12)


def test_a_signal_can_be_written_and_released_while_a_mapping_is_in_between(tmp_path):
    made = prepared(rate_car(tmp_path))
    with Simulation(made.system, h=made.h, until=made.until) as simulation:
        simulation.step()
        simulation.write("plant.actuation.delta_f", 0.05)
        simulation.step()
        assert simulation.read("plant.y.delta") == pytest.approx(0.05)
        simulation.release("plant.actuation.delta_f")
        simulation.step()
        asked = simulation.frame()["controller.actuation.delta_f"]
        assert simulation.read("plant.y.delta") == pytest.approx(asked.iloc[-2], abs=1e-12)


def test_an_fmu_in_a_system_of_ones_own_is_mapped_where_it_has_to_be(built_fmus):
    theirs = Fmu(built_fmus / "fmi2" / "bicycle.fmu")
    assert mapped("plant", PLANT, theirs) is theirs
    with pytest.raises(RequestError, match="car: ramp_traffic.fmu: found no variable for actuation.delta_f"):
        mapped("car", PLANT, Fmu(built_fmus / "fmi2" / "ramp_traffic.fmu"))


def test_a_plant_made_with_pythonfmu(own, python_fmu):
    made = prepared(python_fmu)
    assert [r for r in made.remarks if "modelDescription.xml" not in r] == [
        "plant: PythonCar.fmu: needs the tool that made it to be installed",
        "plant.actuation.delta_f -> delta_f, without a unit, taken as rad",
        "plant.actuation.T_r -> T_r, without a unit, taken as N.m",
        "plant.state.x <- x, without a unit, taken as m",
        "plant.state.y <- y, without a unit, taken as m",
        "plant.state.psi <- psi, without a unit, taken as rad",
        "plant.state.v_x <- v_x, without a unit, taken as m/s",
        "plant.state.v_y <- v_y, without a unit, taken as m/s",
        "plant.state.r <- r, without a unit, taken as rad/s",
        "plant: PythonCar.fmu says not what its outputs depend on; "
        "as in the socket `plant`, inputs act through the step",
    ]
    assert_same(run(made), own)


def test_a_mapping_that_says_only_some_signals_is_written_the_same_each_time(built_fmus, tmp_path):
    theirs = tmp_path / "theirs.toml"
    fmu = built_fmus / "fmi3" / "stationary.fmu"
    theirs.write_text(f'fmu = "{fmu}"\nsocket = "plant"\n[state]\npsi = {{ variable = "state.psi", factor = 0.5 }}\n')
    ssp.write(prepare("idle", Options(mode="blocks", replacements={"plant": str(theirs)})), tmp_path / "system.ssp")
    ssp.write(ssp_reader.read(tmp_path / "system.ssp"), tmp_path / "again.ssp")
    assert (tmp_path / "again.ssp").read_bytes() == (tmp_path / "system.ssp").read_bytes()


def test_a_run_with_a_mapped_fmu_can_be_repeated_from_its_ssp(tmp_path):
    made = prepared(foreign.right_handed_mapping(tmp_path))
    ssp.write(made, tmp_path / "system.ssp")
    found = ssp_reader.read(tmp_path / "system.ssp")
    assert isinstance(found.system.units["plant"], Mapped)
    assert found.system.units["plant"].parameters == made.system.units["plant"].parameters
    pd.testing.assert_frame_equal(run(found), run(made), check_exact=True)
    ssp.write(found, tmp_path / "again.ssp")
    assert (tmp_path / "again.ssp").read_bytes() == (tmp_path / "system.ssp").read_bytes()


def test_the_summary_names_the_file_and_the_mapping(tmp_path):
    told = summary.units(prepared(foreign.right_handed_mapping(tmp_path)).system)["plant"]
    assert (told["runs_as"], told["file"]) == ("FMI 2.0", "theirs.fmu")
    assert 'v_x = "car.speed"' in told["mapping"]
    assert 'axes = "y_right"' in told["mapping"]


@pytest.mark.parametrize("isolate", [(), ("plant",)])
def test_local_variables_behind_a_mapping_are_recorded_as_the_fmu_has_them(tmp_path, isolate):
    path = foreign.right_handed_mapping(tmp_path)
    root = etree.fromstring(entries(tmp_path / "theirs.fmu")["modelDescription.xml"])
    variables = [v.get("name") for v in root.iterfind("ModelVariables/ScalarVariable")]
    root.find("ModelVariables/ScalarVariable[@name='car.engine']").set("causality", "local")
    for unknown in root.findall(f"ModelStructure/*/Unknown[@index='{variables.index('car.engine') + 1}']"):
        unknown.getparent().remove(unknown)
    changed = {"modelDescription.xml": etree.tostring(root, xml_declaration=True, encoding="UTF-8")}
    copied(tmp_path / "theirs.fmu", tmp_path / "changed.fmu", changed).replace(tmp_path / "theirs.fmu")
    made = prepare(
        "static",
        Options(
            mode="blocks",
            stop_time=0.5,
            replacements={"plant": str(path), "controller": "lqr"},
            record=["plant.car.*", "plant.state.v_x"],
            isolate=isolate,
        ),
    )
    with Simulation(made.system, h=made.h, until=made.until, record=made.record) as simulation:
        simulation.run()
        frame = simulation.frame()
    assert frame.columns.tolist() == ["time", "plant.state.v_x", "plant.car.engine"]
    assert frame["plant.car.engine"].eq(42).all()
    assert frame["plant.state.v_x"].iloc[0] == pytest.approx(10)
