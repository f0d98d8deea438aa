"""The three sockets and their buses, signal by signal."""

from __future__ import annotations

import re

import pytest

from components import BLOCKS
from components.interfaces.record import variables
from components.interfaces.sockets import CONTROLLER, PLANT, SOCKETS, TRAFFIC
from components.interfaces.units_of_measurement import BASE_UNITS, UNITS_OF_MEASUREMENT

POSE = {"x": "m", "y": "m", "psi": "rad"}
STATE = {**POSE, "v_x": "m/s", "v_y": "m/s", "r": "rad/s"}
ACTUATION = {"delta_f": "rad", "T_r": "N.m"}
TYRE = {"alpha_f": "rad", "alpha_r": "rad", "F_cf": "N", "F_cr": "N", "mu_f": "1", "mu_r": "1"}
MOTION = {"a_x": "m/s2", "a_y": "m/s2", "r_dot": "rad/s2"}
OBSTACLES = {"valid": "1", "id": "1", **POSE, "v": "m/s", "length": "m", "width": "m"}
PATH = {"x": "m", "y": "m"}
PLAN = dict.fromkeys(("x", "y", "x_d", "y_d", "y_upper", "y_lower"), "m")
SOLVER = dict.fromkeys(("status", "iterations", "cost", "kkt"), "1")


@pytest.mark.parametrize(
    ("socket", "inputs", "outputs", "optional"),
    [
        (PLANT, {"actuation": ACTUATION}, {"state": STATE}, {"tyre": TYRE, "motion": MOTION}),
        (TRAFFIC, {"ego": STATE}, {"obstacles": OBSTACLES}, {}),
        (
            CONTROLLER,
            {"ego": STATE, "obstacles": OBSTACLES},
            {"actuation": ACTUATION},
            {"path": PATH, "plan": PLAN, "solver": SOLVER},
        ),
    ],
)
def test_a_socket_has_the_buses_signals_and_units_of_the_design(socket, inputs, outputs, optional):
    def table(buses):
        return {name: {v.name: v.quantity.unit for v in variables(kind, {"N_p": 3})} for name, kind in buses.items()}

    assert table(socket.inputs) == inputs
    assert table(socket.outputs) == outputs
    assert table(socket.optional) == optional
    assert SOCKETS[socket.name] is socket


@pytest.mark.parametrize("kind", BLOCKS.values(), ids=BLOCKS)
def test_every_block_of_the_catalogue_fits_the_socket_it_names(kind):
    assert kind.socket.problems("unit", kind.inputs(), kind.outputs()) == []


@pytest.mark.parametrize("kind", BLOCKS.values(), ids=BLOCKS)
def test_no_block_fits_a_socket_it_does_not_name(kind):
    for socket in SOCKETS.values():
        if socket is not kind.socket:
            assert socket.problems("unit", kind.inputs(), kind.outputs())


SYMBOLS = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "Hz": {"s": -1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    **{unit: {unit: 1} for unit in BASE_UNITS},
    "1": {},
}


@pytest.mark.parametrize("unit", UNITS_OF_MEASUREMENT)
def test_the_exponents_of_a_unit_are_those_its_spelling_says(unit):
    above, _, below = unit.partition("/")
    found: dict[str, int] = {}
    for part, direction in ((above, 1), (below, -1)):
        for factor in filter(None, part.split(".")):
            symbol, power = re.fullmatch(r"([A-Za-z]+|1)(\d*)", factor).groups()
            for base, exponent in SYMBOLS[symbol].items():
                found[base] = found.get(base, 0) + direction * exponent * int(power or 1)
    assert {base: n for base, n in found.items() if n} == dict(UNITS_OF_MEASUREMENT[unit].base.exponents)
