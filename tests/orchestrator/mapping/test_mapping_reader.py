"""Mapping files are read, and whatever is wrong with one is told at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from components.interfaces.problem import RequestError
from orchestrator.mapping.mapping_file import Amount, Entry
from orchestrator.mapping.mapping_reader import parse_mapping, read_mapping


def problems(content, socket="plant"):
    with pytest.raises(RequestError) as error:
        parse_mapping(content, "map.toml", socket, Path())
    return [str(p) for p in error.value.problems]


def test_a_file_names_its_fmu_relative_to_itself(tmp_path):
    path = tmp_path / "theirs.toml"
    path.write_text(
        'fmu = "sub/theirs.fmu"\nsocket = "plant"\n[state]\nx = "X"\nr = { variable = "w", unit = "deg/s" }\n'
    )
    found = read_mapping(path)
    assert found.fmu == tmp_path / "sub/theirs.fmu"
    assert found.signals == {"state.x": (Entry(("X",)),), "state.r": (Entry(("w",), unit="deg/s"),)}


def test_amounts_have_units_and_may_have_sources():
    content = {
        "state": {
            "reference": {"point": "front_axle", "distance": {"value": 1.2, "unit": "m", "source": "drawing"}},
            "v_y": {"constant": {"value": 0, "unit": "m/s"}},
        },
        "parameters": {"mass": {"value": 2, "unit": "t"}, "abs": True},
    }
    found = parse_mapping(content, "map.toml", "plant", Path())
    assert found.references == {"state": ("front_axle", Amount(1.2, "m"))}
    assert found.signals["state.v_y"][0].constant == Amount(0, "m/s")
    assert found.parameters == {"mass": Amount(2, "t"), "abs": Amount(True)}  # noqa: FBT003


ENTRY = "R_w, angle, as, constant, factor, limit, m, max, min, offset, ratio, unit, unused, variable"


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (
            {"stat": {"x": "X"}},
            "stat: found an unknown entry; valid: actuation, axes, constants, feedthrough, fmu, motion, parameters, "
            "socket, state, tyre. Did you mean `state`?",
        ),
        (
            {"state": {"v_z": "X"}},
            "state.v_z: found an unknown entry; valid: psi, r, reference, v_x, v_y, velocity, x, y. "
            "Did you mean `v_y`?",
        ),
        (
            {"state": {"velocity": "speed_and_slip", "v_x": "X"}},
            "state.v_x: found an unknown entry; valid: beta, psi, r, reference, v, velocity, x, y",
        ),
        (
            {"state": {"x": {"variable": "X", "factr": 2}}},
            f"state.x.factr: found an unknown entry; valid: {ENTRY}. Did you mean `factor`?",
        ),
        ({"state": 3}, "state: found `3`; valid: a table"),
        (
            {"state": {"x": 3}},
            'state.x: found `3`; valid: the name of a variable, or a table. Write { variable = "...", unit = "..." }.',
        ),
        (
            {"state": {"x": {"unit": "m"}}},
            "state.x: found `{'unit': 'm'}`; valid: one of variable, constant, unused. "
            'Write { variable = "...", unit = "..." }.',
        ),
        (
            {"state": {"x": {"variable": 3}}},
            "state.x.variable: found `3`; valid: the name of a variable, or a list of names",
        ),
        ({"state": {"x": {"variable": "X", "unit": 3}}}, "state.x.unit: found `3`; valid: the name of a unit"),
        (
            {"state": {"x": {"variable": "X", "offset": 3}}},
            'state.x.offset: found `3`; valid: a number with its unit. Write { value = ..., unit = "..." }.',
        ),
        ({"state": {"x": {"variable": "X", "factor": "big"}}}, "state.x.factor: found `big`; valid: a number"),
        ({"axes": "left"}, "axes: found `left`; valid: iso8855, y_right"),
        ({"feedthrough": "no"}, "feedthrough: found `no`; valid: true or false"),
        ({"fmu": 3}, "fmu: found `3`; valid: the path of an FMU, relative to this file"),
        ({"state": {"velocity": "polar"}}, "state.velocity: found `polar`; valid: body, road, speed_and_slip"),
        ({"actuation": {"velocity": "speed_and_slip"}}, "actuation.velocity: found `speed_and_slip`; valid: body"),
        (
            {"state": {"reference": "rear"}},
            "state.reference.point: found `rear`; valid: ahead, centre_of_gravity, front_axle, rear_axle. "
            "Did you mean `rear_axle`?",
        ),
        (
            {"state": {"reference": "rear_axle"}},
            "state.reference.distance: found nothing; valid: the distance from the centre of gravity, with its unit",
        ),
        (
            {"actuation": {"delta_f": {"variable": "w", "as": "force"}}},
            "actuation.delta_f.as: found `force`; valid: steering_rate, steering_wheel_angle",
        ),
        (
            {"actuation": {"delta_f": {"variable": "w", "as": "steering_wheel_angle"}}},
            "actuation.delta_f.ratio: found nothing; valid: a number with its unit, for `steering_wheel_angle`",
        ),
        (
            {"actuation": {"T_r": {"variable": "w", "as": "axle_torque", "m": {"value": 1, "unit": "kg"}}}},
            "actuation.T_r.m: found `{'value': 1, 'unit': 'kg'}`, which `as` does not ask for; "
            "valid: a part of acceleration",
        ),
        ({"socket": "traffic"}, "socket: found `traffic`; valid: `plant`, the socket that it is given for"),
        ({"socket": "plnt"}, "socket: found `plnt`; valid: controller, plant, traffic. Did you mean `plant`?"),
    ],
)
def test_what_is_wrong_is_told_with_file_and_key(content, text):
    assert problems(content) == [f"map.toml: {text}"]


def test_everything_is_told_at_once():
    content = {"axes": "left", "state": {"x": 3, "v_z": "X"}, "actuation": {"T_r": {"variable": "w", "as": "speed"}}}
    assert len(problems(content)) == 4


def test_a_file_has_to_say_its_socket_where_nobody_else_does():
    assert problems({}, None) == [
        "map.toml: socket: found nothing; valid: controller, plant, traffic. Say which socket the FMU fills."
    ]
