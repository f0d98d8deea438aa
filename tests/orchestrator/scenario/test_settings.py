"""Texts of `--set` and `--record`, and what is said of those of another form."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from orchestrator.scenario.resolution import Setting
from orchestrator.scenario.settings import parse_record, parse_settings


@pytest.mark.parametrize(
    ("text", "unit", "assignment"),
    [
        ("controller.b_3=1e-2", "controller", "b_3=1e-2"),
        ("traffic.x_start[2]=99.5", "traffic", "x_start[2]=99.5"),
        ("plant.tyre.mu=0.5", "plant", "tyre.mu=0.5"),
        ("plant.file=a=b", "plant", "file=a=b"),
        ("plant.file=", "plant", "file="),
        ("plant.file=two\nlines", "plant", "file=two\nlines"),
        ("plant.der(x)[1, 2]=1", "plant", "der(x)[1, 2]=1"),
        ("plant.a b 'c' ä=1", "plant", "a b 'c' ä=1"),
    ],
)
def test_a_setting_is_a_unit_and_a_text_that_its_variables_divide(text, unit, assignment):
    assert parse_settings([text])[unit] == [Setting(unit, assignment)]


def test_every_unit_has_its_settings_in_their_order():
    found = parse_settings(["plant.m=1", "scene.y_left=2.0", "plant.m=3"])
    assert found == {
        "plant": [Setting("plant", "m=1"), Setting("plant", "m=3")],
        "traffic": [],
        "controller": [],
        "scene": [Setting("scene", "y_left=2.0")],
    }
    assert parse_settings([], any_unit=True) == {}


def test_a_unit_may_have_any_name_where_units_are_not_sockets():
    assert parse_settings(["motor.k=1"], any_unit=True) == {"motor": [Setting("motor", "k=1")]}


def test_all_settings_of_another_form_come_at_once():
    texts = ["b_3=1", "plant.m", "plant.=1", "=plant.m", "driver.k=1"]
    with pytest.raises(RequestError) as error:
        parse_settings(texts)
    form = "found text of another form; valid: UNIT.PARAMETER=VALUE. Try controller.b_3=1e-2."
    assert str(error.value).splitlines() == [
        *(f"--set {text}: {form}" for text in texts[:4]),
        "--set driver.k=1: found the unknown unit `driver`; valid: controller, plant, scene, traffic",
    ]


def test_a_pattern_is_kept_at_every_tick_unless_a_number_says_otherwise():
    assert parse_record(["plant.*", "controller.plan.*:10", "traffic.*:0"]) == {
        "plant.*": 1,
        "controller.plan.*": 10,
        "traffic.*": 0,
    }
    assert parse_record(["*:5", "*"]) == {"*": 1}
    assert parse_record([]) == {}


def test_all_patterns_of_another_form_come_at_once():
    with pytest.raises(RequestError) as error:
        parse_record(["plant.*:often", "plant.*", ":3"])
    valid = "PATTERN or PATTERN:N, N a whole number of ticks. Try plant.*:10."
    assert str(error.value).splitlines() == [
        f"--record plant.*:often: found text of another form; valid: {valid}",
        f"--record :3: found text of another form; valid: {valid}",
    ]
