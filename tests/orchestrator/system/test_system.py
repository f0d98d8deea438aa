"""A system is checked completely, all problems at once, before anything runs."""

from __future__ import annotations

from typing import final

import pytest

from components import BLOCKS
from components.interfaces.block import Block, NoState, block
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.problem import RequestError
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.sockets import PLANT, SOCKETS, standard_wiring
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.source import Fmu, InProcess, block_source
from orchestrator.system.system import System

WIRING = standard_wiring()


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks")).system


def problems(**changed):
    with pytest.raises(RequestError) as error:
        System(**changed)
    return str(error.value).splitlines()


def test_wires_between_buses_become_wires_between_their_signals(static):
    wires = [str(c) for c in static.connections]
    assert "controller.actuation.delta_f -> plant.actuation.delta_f" in wires
    assert "traffic.obstacles.valid -> controller.obstacles.valid" in wires
    assert len(wires) == 2 + 6 + 6 + 8


def test_signals_can_be_wired_one_by_one(static):
    wiring = {k: v for k, v in WIRING.items() if k != "plant.actuation"}
    wiring |= {f"plant.actuation.{s}": f"controller.actuation.{s}" for s in ("delta_f", "T_r")}
    assert {str(c) for c in System(static.units, wiring).connections} == {str(c) for c in static.connections}


def test_an_unknown_unit_is_named_with_the_known_ones(static):
    found = problems(units=static.units, wiring={**WIRING, "plant.actuation": "driver.actuation"})
    assert found[0] == (
        "driver.actuation -> plant.actuation: found the unknown unit `driver`; valid: controller, plant, traffic"
    )


def test_an_unknown_port_suggests_the_nearest(static):
    found = problems(units=static.units, wiring={**WIRING, "plant.actuation.delta": "controller.actuation.delta_f"})
    assert found[0].startswith("plant.actuation.delta: found no such input; valid: actuation.T_r, actuation.delta_f")
    assert found[0].endswith("Did you mean `actuation.delta_f`?")


def test_a_wrong_unit_is_told_with_both_sides(static):
    wiring = {k: v for k, v in WIRING.items() if k != "plant.actuation"}
    wiring |= {"plant.actuation.delta_f": "controller.actuation.T_r", "plant.actuation.T_r": "controller.actuation.T_r"}
    assert problems(units=static.units, wiring=wiring) == [
        "controller.actuation.T_r -> plant.actuation.delta_f: found Float64 in `N.m`; valid: Float64 in `rad`"
    ]


def test_a_wrong_type_and_shape_are_told(static):
    wiring = {k: v for k, v in WIRING.items() if k != "plant.actuation"}
    wiring |= {"plant.actuation.delta_f": "controller.path.x", "plant.actuation.T_r": "controller.solver.iterations"}
    assert problems(units=static.units, wiring=wiring) == [
        "controller.path.x -> plant.actuation.delta_f: found Float64 in `m` of shape (15); valid: Float64 in `rad`",
        "controller.solver.iterations -> plant.actuation.T_r: found Int32 in `1`; valid: Float64 in `N.m`",
    ]


def test_two_sources_on_one_input_are_refused(static):
    found = problems(units=static.units, wiring={**WIRING, "plant.actuation.T_r": "controller.actuation.T_r"})
    assert found == [
        "plant.actuation.T_r: found two sources, controller.actuation.T_r and controller.actuation.T_r;"
        " valid: one source"
    ]
    found = problems(units=static.units, wiring=WIRING, held={"plant.actuation.T_r": 0.0})
    assert found == [
        "plant.actuation.T_r: found two sources, controller.actuation.T_r and a held value; valid: one source"
    ]


def test_an_input_without_a_source_is_refused_and_can_be_held(static):
    wiring = {k: v for k, v in WIRING.items() if k != "plant.actuation"}
    found = problems(units=static.units, wiring=wiring, held={"plant.actuation.T_r": 0.0})
    assert found == [
        "plant.actuation.delta_f: found no source; valid: a connection or a held value. Connect it, or give it a value."
    ]
    held = {"plant.actuation.T_r": 0.0, "plant.actuation.delta_f": 0.1}
    assert System(static.units, wiring, held).held == held


def test_a_held_value_is_checked(static):
    wiring = {k: v for k, v in WIRING.items() if k != "plant.actuation"}
    held = {"plant.actuation.T_r": float("nan"), "plant.actuation.delta_f": True, "plant.wind": 1.0}
    found = problems(units=static.units, wiring=wiring, held=held)
    assert found[0] == "plant.actuation.T_r: found nan; valid: finite number [N.m]"
    assert found[1] == "plant.actuation.delta_f: found `True` (true/false); valid: finite number [rad]"
    assert found[2].startswith("plant.wind: found a value for an input that does not exist; valid: controller.ego.psi")


def test_parameters_are_checked_all_at_once(static):
    plant = InProcess(BLOCKS["bicycle"], {"m": -1.0, "mass": 3.0, "mu": float("inf")})
    found = problems(units={**static.units, "plant": plant}, wiring=WIRING)
    assert found[0] == "plant.m: found -1.0; valid: 1 <= finite number [kg]"
    assert found[1].startswith("plant.mass: found an unknown parameter; valid: a parameter of `bicycle`: C_alpha_f")
    assert found[2] == "plant.mu: found inf; valid: 0.01 <= finite number <= 2"
    assert found[3] == (
        "plant.I_z: found no value; valid: 1 <= finite number [kg.m2]."
        " Give it with its unit and source in the scenario, or with --set plant.I_z=VALUE."
    )
    assert len(found) == 3 + 13


def test_a_unit_that_does_not_fit_its_socket_is_told_what_is_missing(static):
    found = problems(units={**static.units, "plant": static.units["traffic"]}, wiring=WIRING, sockets=SOCKETS)
    assert found[0] == (
        "plant.state.x: found nothing; valid: an output `state.x` (Float64 in `m`), as the socket `plant` asks for"
    )


def test_a_file_that_is_no_fmu_is_refused(static, tmp_path):
    path = tmp_path / "plant.fmu"
    with pytest.raises(RequestError, match="found no such file; valid: an FMU"):
        System({**static.units, "plant": Fmu(path)}, WIRING)
    path.write_text("hello")
    with pytest.raises(RequestError, match="found a file that is no zip archive; valid: an FMU"):
        System({**static.units, "plant": Fmu(path)}, WIRING)


@record
class Inputs:
    """A plant that also feels the wind."""

    actuation: Actuation


@record
class Outputs:
    """State, and a signal of its own."""

    state: VehicleState
    own: Actuation


@final
@block(PLANT)
class WithMore(Block[Inputs, NoState, Outputs]):
    """Plant with an output of its own."""

    k: float = quantity("1", "nothing much")

    def start(self):
        return NoState()

    def output(self, x, u):
        state = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=0.0, v_y=0.0, r=0.0)
        return Outputs(state=state, own=u.actuation)

    def step(self, x, u, h):
        return x


def test_outputs_beyond_the_socket_are_welcome(static):
    plant = block_source(WithMore(k=1.0))
    assert System({**static.units, "plant": plant}, WIRING, sockets=SOCKETS).variable("plant.own.T_r").size == 1
