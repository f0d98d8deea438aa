"""Scenario files as they are written, and what is said of those that do not fit."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.scenario_file import SCENARIOS, SocketFilling, names, parse_scenario, read
from orchestrator.system.files import Given


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
    assert found[0].startswith("mine.toml: trafic: found an unknown entry; valid: allow_nonfinite, controller, ")
    assert found[0].endswith("Did you mean `traffic`?")
    assert messages(scenario(plant={"blok": "stationary"})) == [
        "mine.toml: plant.blok: found an unknown entry; valid: block, fmu, interface, mapping, parameters, step, use."
        " Did you mean `block`?"
    ]


def test_a_value_without_its_table_is_refused_with_the_form_to_write():
    found = messages(scenario(plant={"block": "stationary", "parameters": {"x_start": 1.0}}))
    assert found == ['mine.toml: plant.parameters.x_start: found `1.0`; valid: { value = 1.0, unit = "..." }']


def test_what_a_scenario_leaves_out_is_filled_in():
    found = parse_scenario(scenario(), "mine.toml")
    assert (found.title, found.description) == ("t", "d")
    assert (found.experiment.algorithm, found.experiment.solve_loops) == ("sequential", False)
    assert {name: filling.block for name, filling in found.units.items()} == {
        "plant": "stationary",
        "traffic": "empty_road",
        "controller": "coast",
    }
    assert found.scene.parameters == found.record == {}


def test_signals_are_recorded_at_a_whole_number_of_ticks():
    assert parse_scenario(scenario(record={"*": 0, "plant.*": 3}), "mine.toml").record == {"*": 0, "plant.*": 3}
    assert messages(scenario(record={"*": -1, "plant.*": 1.5})) == [
        "mine.toml: record.*: found `-1`; valid: greater than or equal to 0",
        "mine.toml: record.plant.*: found `1.5`; valid: a valid integer",
    ]


def test_a_socket_takes_parameter_files_one_over_the_other_and_its_own_values_over_all():
    own = {"m": Given(value=1.0, unit="kg", source="mine")}
    found = SocketFilling(block="bicycle", use=["vehicle", "static_obstacles"], parameters=own).given("plant")
    assert found == {**parameter_set("vehicle"), **parameter_set("static_obstacles"), **own}
    assert parameter_set("vehicle")["m"] != own["m"]
    assert SocketFilling(block="bicycle").given("plant") == {}


def test_an_unknown_parameter_file_is_told_with_those_there_are():
    with pytest.raises(RequestError) as error:
        SocketFilling(block="bicycle", use=["vehicel"]).given("plant")
    assert str(error.value).startswith("plant.use: found the unknown parameter file `vehicel`; valid: actuators, ")
    assert str(error.value).endswith("Did you mean `vehicle`?")


@pytest.mark.parametrize("name", names())
def test_every_scenario_that_comes_along_is_read_by_its_name_and_by_its_path(name):
    found, content = read(name)
    assert found == name
    assert content.title
    assert read(str(SCENARIOS / f"{name}.toml")) == (name, content)


def test_a_name_that_is_no_scenario_is_told_with_those_there_are():
    for request, remedy in (("statik", "Did you mean `static`?"), ("zzz", "`macrostep list` shows them all.")):
        with pytest.raises(RequestError) as error:
            read(request)
        assert str(error.value) == (
            f"scenario `{request}`: found no such scenario; valid: {', '.join(names())}, or a .toml file. {remedy}"
        )


def test_a_file_s_own_path_stands_in_its_messages(tmp_path):
    (tmp_path / "mine.toml").write_text("title = 't'\n")
    with pytest.raises(RequestError) as error:
        read(str(tmp_path / "mine.toml"))
    assert str(error.value).splitlines()[0] == (
        f"{tmp_path}/mine.toml: experiment: found nothing; valid: an entry of this name"
    )
