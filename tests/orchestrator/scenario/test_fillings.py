"""Parts of a scenario that are FMUs: files beside the scenario, parameters in their units, buses that are not read."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from orchestrator.mapping.mapped import Mapped
from orchestrator.scenario import scenario_file
from orchestrator.scenario.fillings import in_units_of
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.files import Given
from orchestrator.system.source import Fmu
from tests.orchestrator import foreign


@pytest.fixture
def theirs(tmp_path):
    """The right-handed car with its mapping file beside it."""
    return foreign.right_handed_mapping(tmp_path).parent


def wrong(request, **replacements):
    with pytest.raises(RequestError) as error:
        prepare(request, Options(mode="blocks", replacements=replacements))
    return [str(p) for p in error.value.problems]


def scenario_with(folder, plant):
    text = (scenario_file.SCENARIOS / "static.toml").read_text().replace('block = "bicycle"', plant)
    (folder / "mine.toml").write_text(text)
    return str(folder / "mine.toml")


@pytest.mark.parametrize(
    "plant", ['mapping = "theirs.toml"', 'fmu = "theirs.toml"', 'mapping = "theirs.toml"\nfmu = "theirs.fmu"']
)
def test_a_scenario_names_a_mapping_beside_it(theirs, plant):
    made = prepare(scenario_with(theirs, plant), Options(mode="blocks"))
    plant_ = made.system.units["plant"]
    assert isinstance(plant_, Mapped)
    assert plant_.fmu.path == theirs / "theirs.fmu"


def test_an_fmu_that_does_not_fit_is_one_message(theirs):
    (text,) = wrong("static", plant=str(theirs / "theirs.fmu"))
    assert text.startswith(
        "plant: theirs.fmu: found no variable for actuation.delta_f (Float64 in `rad`), actuation.T_r"
    )
    assert f"`macrostep check {theirs}/theirs.fmu --socket plant --out FILE.toml`" in text


def test_a_mapping_without_an_fmu_or_for_another_socket_is_refused(theirs):
    (theirs / "bare.toml").write_text('[state]\nx = "X"\n')
    assert wrong("static", plant=str(theirs / "bare.toml")) == [
        f"{theirs}/bare.toml: fmu: found nothing; valid: the path of the FMU, relative to this file"
    ]
    (theirs / "other.toml").write_text('fmu = "theirs.fmu"\nsocket = "traffic"\n')
    assert wrong("static", plant=str(theirs / "other.toml")) == [
        f"{theirs}/other.toml: socket: found `traffic`; valid: `plant`, the socket that it is given for"
    ]
    (theirs / "gone.toml").write_text('fmu = "gone.fmu"\n')
    assert wrong("static", plant=str(theirs / "gone.toml"))[0].startswith(f"{theirs}/gone.fmu: found no such file")


def test_problems_of_mappings_and_parameters_come_together(theirs):
    text = foreign.RIGHT_HANDED.replace('"car.south"', '"car.north"')
    (theirs / "theirs.toml").write_text(text + "[parameters]\nm = 1.0\n")
    found = wrong("static", plant=str(theirs / "theirs.toml"))
    assert found == [
        "plant.m: found an unknown parameter; valid: car.force, car.wheel",
        f"{theirs}/theirs.toml: state.y: found the unknown variable `car.north`; valid: car.drift, car.east, "
        "car.engine, car.heading, car.south, car.speed, car.yaw_rate. Did you mean `car.south`?",
    ]


def test_a_scenario_names_the_interface_type_of_an_fmu(theirs):
    plant = prepare(scenario_with(theirs, 'fmu = "theirs.toml"\ninterface = "cs"'), Options(mode="blocks"))
    assert plant.system.units["plant"].describe().interface_type == "CoSimulation"
    assert wrong(scenario_with(theirs, 'fmu = "theirs.toml"\ninterface = "ModelExchange"')) == [
        f"{theirs}/theirs.fmu: found no ModelExchange; valid: CoSimulation. Export it with both, or choose what it has."
    ]
    assert wrong(scenario_with(theirs, 'fmu = "theirs.toml"\ninterface = "both"')) == [
        "plant.interface: found `both`; valid: cs (CoSimulation) or me (ModelExchange)"
    ]
    assert wrong(scenario_with(theirs, 'block = "bicycle"\ninterface = "me"')) == [
        "plant.interface: found `me` for a block; valid: it for an FMU only"
    ]


def given(value, unit="1"):
    return Given(value=value, unit=unit, source="here")


def test_parameters_reach_the_fmu_in_its_own_units(tmp_path, built_fmus):
    names = {"m": "m", "v_x_start": "v_x_start", "l_f": "l_f"}
    units = {"m": None, "v_x_start": "km/h", "l_f": "mm"}
    fmu = foreign.relabelled(built_fmus / "fmi2" / "bicycle.fmu", tmp_path / "theirs.fmu", names, units)
    interface = Fmu(fmu).interface
    wanted = {"m": given(2100.0, "kg"), "v_x_start": given(10.0, "m/s"), "l_f": given(1.3, "m"), "mu": given(0.5, "kg")}
    found, other = in_units_of({**wanted, "nobody": given(1.0)}, interface)
    assert {n: (g.value, g.unit) for n, g in found.items()} == {
        "m": (2100.0, ""),
        "v_x_start": (pytest.approx(36.0), "km/h"),
        "l_f": (pytest.approx(1300.0), "mm"),
    }
    assert other == {"mu": "0.5 [kg] against 0.01 <= finite number <= 2"}
    (tmp_path / "theirs.toml").write_text(
        'fmu = "theirs.fmu"\n[parameters]\nm = { value = 2.1, unit = "t" }\nl_f = { value = 130, unit = "cm" }\n'
    )
    made = prepare("static", Options(mode="blocks", replacements={"plant": str(tmp_path / "theirs.toml")}))
    assert made.system.units["plant"].parameters["l_f"] == pytest.approx(1300.0)
    assert made.sources["plant.l_f"]["source"] == "theirs.toml"


def test_a_shorter_array_leaves_the_other_elements_as_the_fmu_has_them(built_fmus):
    interface = Fmu(built_fmus / "fmi3" / "ramp_traffic.fmu").interface
    starts = np.asarray(interface.starts["x_start"]).tolist()
    found, _ = in_units_of({"x_start": given([7.0, 8.0], "m")}, interface)
    assert found["x_start"].value == [7.0, 8.0, *starts[2:]]


def test_traffic_that_does_not_read_the_ego_vehicle_is_not_wired_to_it(tmp_path, built_fmus):
    fmu = foreign.relabelled(
        built_fmus / "fmi2" / "ramp_traffic.fmu", tmp_path / "cars.fmu", {f"ego.{n}": f"own.{n}_1" for n in ("x", "y")}
    )
    text = "[ego]\n" + "".join(f"{n} = {{ unused = true }}\n" for n in ("x", "y", "psi", "v_x", "v_y", "r"))
    (tmp_path / "cars.toml").write_text(f'fmu = "{fmu.name}"\n{text}')
    made = prepare("static", Options(mode="blocks", replacements={"traffic": str(tmp_path / "cars.toml")}))
    assert not any(c.unit == "traffic" for c in made.system.connections)
    assert any(remark.startswith("traffic: nothing drives own.x_1 ... ego.r of cars.fmu") for remark in made.remarks)
