"""What the scene consists of, and the parameter set that it is made of."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError, raise_if_any
from components.interfaces.record import variables
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.resolution import resolve
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene

LENGTHS = ("ego_length", "ego_width", "l_gap")
PLACES = ("y_left", "y_right", "y_lane", "y_adjacent", "y_third")


def test_the_scene_is_lengths_and_places_in_metres():
    assert {v.name: (v.quantity.unit, v.shape) for v in variables(Scene)} == dict.fromkeys(
        (*LENGTHS, *PLACES), ("m", ())
    )


def test_the_parameter_set_gives_every_value_and_a_road_with_two_lanes():
    found = resolve("scene", variables(Scene), parameter_set("scene"))
    assert found.problems == []
    scene = Scene(**found.values)
    assert scene.y_right < scene.y_lane < scene.y_adjacent < scene.y_left
    assert scene.lanes() == [scene.y_lane, scene.y_adjacent]


@pytest.mark.parametrize(("y_third", "lanes"), [(-3.5, [-3.5, 0.0, 3.5]), (7.0, [0.0, 3.5, 7.0]), (9.0, [0.0, 3.5])])
def test_a_third_lane_is_on_the_road_or_there_is_none(y_third, lanes):
    given = {
        n: Given(value=y, unit="m", source="test") for n, y in (("y_third", y_third), ("y_right", -5), ("y_left", 9))
    }
    assert Scene(**resolve("scene", variables(Scene), parameter_set("scene"), given).values).lanes() == lanes


@pytest.mark.parametrize("name", LENGTHS)
def test_a_length_is_not_negative(name):
    given = {name: Given(value=-1.0, unit="m", source="test")}
    with pytest.raises(RequestError, match=f"scene.{name}: found -1.0; valid: 0 <= finite number \\[m\\]"):
        raise_if_any(resolve("scene", variables(Scene), parameter_set("scene"), given).problems)
