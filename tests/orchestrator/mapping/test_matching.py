"""Names that leave no doubt, in the spellings that tools have."""

from __future__ import annotations

import pytest

from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.sockets import CONTROLLER, PLANT, TRAFFIC
from orchestrator.mapping.matching import match

STATE = ("x", "y", "psi", "v_x", "v_y", "r")


def offered(*names, shape=(), kind=Type.FLOAT64):
    return [Variable(name, Quantity("", name, kind, shape)) for name in names]


def matched(socket, role, *variables):
    found, doubtful = match(socket, socket.signals(role), variables)
    return {signal: list(m.names) for signal, m in found.items()}, doubtful


@pytest.mark.parametrize(
    "spelling",
    [
        "state.{}",
        "state_{}",
        "State.{}",
        "stateBus.{}",
        "Out_state.{}",
        "out.state.{}",
        "plant.state.{}",
        "vehicle_state_{}",
        "ego.{}",
        "{}",
        "Chassis.Sensors.{}",
    ],
)
def test_a_state_is_found_in_many_spellings(spelling):
    names = [spelling.format(leaf) for leaf in STATE]
    found, _ = matched(PLANT, "outputs", *offered(*names))
    assert found == {f"state.{leaf}": [name] for leaf, name in zip(STATE, names, strict=True)}


@pytest.mark.parametrize(
    "names", [("State.vx", "State.vy"), ("stateVx", "stateVy"), ("VX", "VY"), ("state.V_x", "state.V_y")]
)
def test_case_and_underscores_do_not_matter(names):
    found, _ = matched(PLANT, "outputs", *offered(*names))
    assert found == {"state.v_x": [names[0]], "state.v_y": [names[1]]}


@pytest.mark.parametrize("spelling", ["In_actuation.{}", "actuation_{}", "actuationBus.{}", "{}", "input.actuation.{}"])
def test_simulink_bus_names(spelling):
    names = [spelling.format(leaf) for leaf in ("delta_f", "T_r")]
    found, _ = matched(PLANT, "inputs", *offered(*names))
    assert found == {"actuation.delta_f": [names[0]], "actuation.T_r": [names[1]]}


def test_a_prefix_that_names_no_bus_is_none():
    assert matched(PLANT, "inputs", *offered("u_delta_f", "u_T_r")) == ({}, {})


def test_the_exact_name_wins():
    found, doubtful = matched(PLANT, "outputs", *offered("x", "state.x", "State_X"))
    assert found == {"state.x": ["state.x"]}
    assert doubtful == {}


def test_two_that_are_equally_good_are_none():
    found, doubtful = matched(PLANT, "outputs", *offered("state_v_x", "State.vx"))
    assert found == {}
    assert doubtful == {"state.v_x": ["State.vx", "state_v_x"]}


def test_two_structures_with_the_whole_bus_are_none():
    names = [f"{car}.{leaf}" for car in ("lead", "tail") for leaf in STATE]
    assert matched(PLANT, "outputs", *offered(*names)) == ({}, {})


@pytest.mark.parametrize(
    "spelling",
    [
        "obstacles[{}].x",
        "obstacles_{}_x",
        "obstacle{}.x",
        "obstacles({}).x",
        "object_{}.x",
        "obstacles.x_{}",
        "Obstacles_{}_.x",
    ],
)
@pytest.mark.parametrize("first", [0, 1])
def test_arrays_of_structures_against_our_structure_of_arrays(spelling, first):
    names = [spelling.format(first + i) for i in range(5)]
    found, _ = matched(TRAFFIC, "outputs", *offered(*reversed(names)))
    assert found == {"obstacles.x": names}


def test_a_gap_in_the_numbers_or_too_many_slots_is_no_array():
    assert matched(TRAFFIC, "outputs", *offered("obstacles[1].x", "obstacles[3].x")) == ({}, {})
    assert matched(TRAFFIC, "outputs", *offered(*(f"obstacles[{i}].x" for i in range(9)))) == ({}, {})
    assert matched(TRAFFIC, "outputs", *offered("obstacles.x", shape=(9,))) == ({}, {})


def test_shapes_tell_the_ego_vehicle_from_the_obstacles():
    found, _ = matched(CONTROLLER, "inputs", *offered("x"), *offered("X", shape=(8,)))
    assert found == {"ego.x": ["x"], "obstacles.x": ["X"]}


def test_a_path_and_a_plan_are_not_mistaken_for_each_other():
    found, doubtful = matched(CONTROLLER, "outputs", *offered("x", shape=(15,)), *offered("path_y", shape=(15,)))
    assert found == {"path.y": ["path_y"]}
    assert doubtful["path.x"] == ["x"]


def test_texts_are_no_signals():
    assert matched(PLANT, "outputs", *offered("state.x", kind=Type.STRING)) == ({}, {})
