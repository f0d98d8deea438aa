"""Every value has a unit and a source, and everything wrong is told at once."""

from __future__ import annotations

import pytest

from components import BLOCKS
from components.interfaces.problem import RequestError
from components.interfaces.record import variables
from orchestrator.scenario.catalogue import default_values
from orchestrator.scenario.parameters import PARAMETERS, parameter_set
from orchestrator.scenario.resolution import resolve
from orchestrator.scenario.scenario_file import parse_scenario
from orchestrator.system.files import Given, read_toml
from orchestrator.system.scene import Scene


@pytest.mark.parametrize("path", sorted(PARAMETERS.values()), ids=lambda p: p.stem)
def test_every_value_has_a_unit_and_a_source(path):
    for name, given in parameter_set(path.stem).items():
        assert given.source, name
        assert given.unit, name


@pytest.mark.parametrize("name", sorted(BLOCKS))
def test_every_block_has_a_complete_parameter_set(name):
    assert set(default_values(BLOCKS[name])) == {v.name for v in BLOCKS[name].parameters()}


def test_the_paper_s_table_1():
    values = default_values(BLOCKS["bicycle"])
    table = {"l_f": 1.2, "l_r": 1.05, "m": 2000, "I_z": 1300, "mu": 0.5, "C_alpha_f": 12000, "C_alpha_r": 12000}
    assert {name: values[name] for name in table} == table


def test_plant_and_controller_share_the_numbers_of_the_vehicle():
    plant, controller = default_values(BLOCKS["bicycle"]), default_values(BLOCKS["mpc"])
    for name in parameter_set("vehicle"):
        assert plant[name] == controller[name]


def test_a_unit_that_differs_is_told():
    given = {"ego_length": Given(value=460.0, unit="cm", source="test")}
    problems = resolve("scene", variables(Scene), parameter_set("scene"), given).problems
    assert [str(p) for p in problems] == ["scene.ego_length: found unit `cm`; valid: unit `m`"]


def scenario(**changed):
    entry = {"value": 1.0, "unit": "s", "source": "test"}
    whole = {
        "title": "t",
        "description": "d",
        "experiment": {"step": entry, "stop_time": entry},
        "plant": {"block": "stationary"},
        "traffic": {"block": "empty_road"},
        "controller": {"block": "coast"},
    }
    return {**whole, **changed}


def messages(content):
    with pytest.raises(RequestError) as error:
        parse_scenario(content, "mine.toml")
    return str(error.value).splitlines()


def test_a_missing_entry_is_told():
    content = scenario()
    del content["plant"]
    assert messages(content) == ["mine.toml: plant: found nothing; valid: an entry of this name"]


def test_an_unknown_entry_suggests_the_nearest():
    found = messages(scenario(trafic={"block": "empty_road"}))
    assert found[0].startswith("mine.toml: trafic: found an unknown entry; valid: controller, description")
    assert found[0].endswith("Did you mean `traffic`?")
    assert messages(scenario(plant={"blok": "stationary"})) == [
        "mine.toml: plant.blok: found an unknown entry; valid: block, fmu, mapping, parameters, step, use."
        " Did you mean `block`?"
    ]


def test_a_value_without_a_source_is_refused_with_the_form_to_write():
    found = messages(scenario(plant={"block": "stationary", "parameters": {"x_start": {"value": 1.0, "unit": "m"}}}))
    assert found == [
        "mine.toml: plant.parameters.x_start.source: found nothing; valid: an entry of this name."
        ' Write NAME = { value = ..., unit = "...", source = "..." }.'
    ]
    found = messages(scenario(plant={"block": "stationary", "parameters": {"x_start": 1.0}}))
    assert found[0].startswith(
        "mine.toml: plant.parameters.x_start: found `1.0`; valid: a valid dictionary or instance"
    )


def test_text_that_is_no_toml_is_told_with_its_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("title = 'x'\n[experiment\n")
    with pytest.raises(RequestError, match=r"mine.toml: found text that is no TOML \(.*line 2.*\); valid: a TOML file"):
        read_toml(path)


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(RequestError, match=r"mine.toml: found a file that cannot be read"):
        read_toml(tmp_path / "mine.toml")
