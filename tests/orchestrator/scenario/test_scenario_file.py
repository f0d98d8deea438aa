"""Scenario files as they are written, and what is said of those that do not fit."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from orchestrator.scenario.scenario_file import parse_scenario


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
