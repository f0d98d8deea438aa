"""From a scenario and a person's options to a checked system.

This also shows `scenario/options.py`.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from components import BLOCKS
from components.interfaces.problem import RequestError
from orchestrator.scenario import scenario_file
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.source import Fmu

BLOCKS_ONLY = Options(mode="blocks")


def wrong(request_, **options):
    with pytest.raises(RequestError) as error:
        prepare(request_, Options(mode="blocks", **options))
    return str(error.value).splitlines()


@pytest.mark.parametrize("name", scenario_file.names())
def test_every_scenario_is_complete(name):
    made = prepare(name, BLOCKS_ONLY)
    assert made.title
    assert made.h > 0
    assert all(told["source"] for told in made.sources.values())


def test_every_block_is_used_by_a_scenario():
    used = {s.interface.kind for n in scenario_file.names() for s in prepare(n, BLOCKS_ONLY).system.units.values()}
    assert used == set(BLOCKS)


def test_the_literal_scenario_differs_in_the_prediction_step_and_its_weight_only():
    tuned, literal = (prepare(n, BLOCKS_ONLY).system.units for n in ("static", "static-literal"))
    assert tuned["plant"].parameters == literal["plant"].parameters
    assert tuned["traffic"].parameters == literal["traffic"].parameters
    a, b = tuned["controller"].parameters, literal["controller"].parameters
    assert {n: (a[n], b[n]) for n in a if a[n] != b[n]} == {"dt": (0.25, 0.1), "b_3": (1e-2, 1e-4)}


def test_an_unknown_scenario_suggests_the_nearest():
    assert wrong("statik") == [
        "scenario `statik`: found no such scenario; valid: "
        + ", ".join(scenario_file.names())
        + ", or a .toml file. Did you mean `static`?"
    ]


def test_an_unknown_block_suggests_the_nearest():
    found = wrong("static", replacements={"plant": "bycicle"})
    assert found == [
        "--plant: found the unknown block `bycicle`; valid: bicycle, bicycle_saturated, commonroad_mb, commonroad_st, "
        "stationary. Did you mean `bicycle`?"
    ]


def test_a_block_of_another_socket_does_not_fit():
    found = wrong("static", replacements={"plant": "coast"})
    valid = "bicycle, bicycle_saturated, commonroad_mb, commonroad_st, stationary"
    assert found == [f"--plant: found `coast`, a block of the socket `controller`; valid: {valid}"]


def test_settings_change_values_arrays_and_elements():
    settings = ["controller.b_3=2e-2", "traffic.x_start[2]=99", "traffic.y_start=[0.0, 0.5]", "scene.ego_width=2.0"]
    made = prepare("static", Options(mode="blocks", settings=settings))
    assert made.system.units["controller"].parameters["b_3"] == 2e-2
    assert made.system.units["traffic"].parameters["x_start"] == [49.5, 99, 110.5, 0, 0, 0, 0, 0]
    assert made.system.units["traffic"].parameters["y_start"] == [0, 0.5, 3.5, 0, 0, 0, 0, 0]
    assert made.scene.ego_width == 2.0
    assert made.sources["controller.b_3"] == {"value": 2e-2, "unit": "s4/rad2", "source": "--set"}
    assert made.sources["controller.m"]["source"] == "paper, Table 1"


@pytest.mark.parametrize(
    ("setting", "text"),
    [
        ("b_3=1", "--set b_3=1: found text of another form; valid: UNIT.PARAMETER=VALUE. Try controller.b_3=1e-2."),
        ("driver.k=1", "--set driver.k=1: found the unknown unit `driver`; valid: controller, plant, scene, traffic"),
        ("plant.m=heavy", "plant.m: found `heavy` (not a number); valid: 1 <= finite number [kg]"),
        ("plant.m=-5", "plant.m: found -5; valid: 1 <= finite number [kg]"),
        ("plant.m=nan", "plant.m: found nan; valid: 1 <= finite number [kg]"),
        ("plant.m=true", "plant.m: found `True` (true/false); valid: 1 <= finite number [kg]"),
        ("plant.m=[1.0]", "plant.m: found shape (1,); valid: shape ()"),
        ("plant.m[1]=3", "plant.m[1]: found no such element; valid: a scalar parameter"),
        ("traffic.x_start[9]=3", "traffic.x_start[9]: found no such element; valid: 1 to 8"),
        ("traffic.x_start[1]=no", "traffic.x_start[1]: found `no` (not a number); valid: finite number [m]"),
        ("traffic.valid[1]=2", "traffic.valid[1]: found `2` (whole number); valid: true or false"),
    ],
)
def test_a_wrong_setting_is_told(setting, text):
    assert wrong("static", settings=[setting]) == [text]


def test_an_unknown_parameter_suggests_the_nearest():
    found = wrong("static", settings=["controller.b3=1"])
    assert found[0].startswith("controller.b3: found an unknown parameter; valid: C_alpha_f")
    assert found[0].endswith("Did you mean `b_3`?")


def test_all_problems_come_at_once():
    assert len(wrong("static", settings=["plant.m=-1", "traffic.a[1]=-1", "controller.q=1", "scene.ego_width=x"])) == 4


def test_a_part_may_use_a_parameter_file_and_its_own_values_win(tmp_path):
    text = (scenario_file.SCENARIOS / "static.toml").read_text()
    own = 'y_start = { value = [0.5], unit = "m", source = "mine" }'
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("[controller]", f"[traffic.parameters]\n{own}\n\n[controller]"))
    made = prepare(str(path), BLOCKS_ONLY)
    assert made.system.units["traffic"].parameters["x_start"] == [49.5, 92.5, 110.5, 0, 0, 0, 0, 0]
    assert made.system.units["traffic"].parameters["y_start"] == [0.5, 0, 0, 0, 0, 0, 0, 0]
    assert made.sources["traffic.v_start"]["source"] == "paper: static"
    assert made.sources["traffic.y_start"]["source"] == "mine"


def test_an_unknown_parameter_file_suggests_the_nearest(tmp_path):
    text = (scenario_file.SCENARIOS / "static.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("static_obstacles", "static_obstacle"))
    found = wrong(str(path))[0]
    assert found.startswith("traffic.use: found the unknown parameter file `static_obstacle`; valid: actuators, ")
    assert found.endswith("Did you mean `static_obstacles`?")


def test_parameters_that_a_replacement_does_not_have_are_left_out_and_told():
    made = prepare("static", Options(mode="blocks", replacements={"traffic": "empty_road"}))
    assert made.remarks == (
        "traffic: `empty_road` has no parameters v_final, v_start, valid, x_start, y_start;"
        " the scenario's are not used",
    )


def test_a_scenario_can_be_a_file_with_an_fmu_in_it(tmp_path, built_fmus):
    fmu = built_fmus / "fmi2" / "bicycle.fmu"
    text = (scenario_file.SCENARIOS / "static.toml").read_text().replace('block = "bicycle"', f'fmu = "{fmu}"')
    path = tmp_path / "mine.toml"
    path.write_text(text)
    made = prepare(str(path), BLOCKS_ONLY)
    assert made.name == "mine"
    assert isinstance(made.system.units["plant"], Fmu)


def test_step_and_stop_time_can_be_given():
    made = prepare("static", Options(mode="blocks", step=0.05, stop_time=2.0))
    assert (made.h, made.until) == (0.05, 2.0)
    assert made.sources["experiment.step"] == {"value": 0.05, "unit": "s", "source": "--step"}


def test_what_is_recorded_stands_in_the_scenario_and_options_replace_it(tmp_path):
    text = (scenario_file.SCENARIOS / "static.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text + '\n[record]\n"*" = 1\n"controller.plan.*" = 10\n')
    assert prepare(str(path), BLOCKS_ONLY).record == {"*": 1, "controller.plan.*": 10}
    chosen = Options(mode="blocks", record=["plant.*", "controller.*:5"])
    assert prepare(str(path), chosen).record == {"plant.*": 1, "controller.*": 5}
    assert prepare("static", BLOCKS_ONLY).record == {"*": 1}
    path.write_text(text + '\n[record]\n"*" = -1\n')
    assert wrong(str(path)) == [f"{path}: record.*: found `-1`; valid: greater than or equal to 0"]


@pytest.mark.parametrize("text", ["plant.*:often", ":3", "plant.*:-1", "plant.*:"])
def test_a_pattern_without_a_whole_number_of_ticks_is_told(text):
    valid = "PATTERN or PATTERN:N, N a whole number of ticks. Try plant.*:10."
    assert wrong("static", record=[text]) == [f"--record {text}: found text of another form; valid: {valid}"]


def test_a_scenario_may_give_values_and_times_in_other_units_of_measurement(tmp_path):
    text = (scenario_file.SCENARIOS / "idle.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace('{ value = 1.0, unit = "s"', '{ value = 1000, unit = "ms"'))
    made = prepare(str(path), BLOCKS_ONLY)
    assert made.until == 1.0
    assert made.sources["experiment.stop_time"]["unit"] == "ms"


def test_all_that_is_wrong_with_a_scenario_and_its_options_is_told_at_once(tmp_path):
    text = (scenario_file.SCENARIOS / "idle.toml").read_text()
    path = tmp_path / "mine.toml"
    text = text.replace('"stationary"', '"stationry"').replace('{ value = 0.1, unit = "s"', '{ value = 0.1, unit = "m"')
    path.write_text(text + '\n[scene]\nuse = ["scen"]\n')
    settings = ["nonsense", "wheel.x=1", "controller.x=1"]
    found = wrong(str(path), settings=settings, algorithm="jacob", record=["plant.*:often"])
    assert [line.partition(": found")[0] for line in found] == [
        "--set nonsense",
        "--set wheel.x=1",
        "mine: plant.block",
        "controller.x",
        "scene.use",
        "experiment.step",
        "algorithm",
        "--record plant.*:often",
    ]


def test_a_step_that_is_none_is_told_also_where_a_unit_has_its_own(tmp_path):
    text = (scenario_file.SCENARIOS / "idle.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("[plant]", '[plant]\nstep = { value = 0.01, unit = "s", source = "ours" }'))
    assert prepare(str(path), BLOCKS_ONLY).system.steps["plant"] == Fraction(1, 10)
    assert wrong(str(path), step=0.0) == ["step: found 0 s; valid: a positive number of seconds"]
    path.write_text(path.read_text().replace("value = 0.01", "value = inf"))
    assert wrong(str(path)) == ["plant.step: found `inf` in `s`; valid: a positive number in `s`"]
    path.write_text(text.replace("{ value = 1.0", f"{{ value = {10**309}"))
    found = "found a number of 310 digits; valid: whole numbers of up to 64 bits"
    assert wrong(str(path)) == [f"{path}: experiment.stop_time.value: {found}"]
