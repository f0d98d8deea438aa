"""What fits a socket, what does not and in which words, and what a socket knows of its buses."""

from __future__ import annotations

from components import BLOCKS
from components.interfaces.record import variables
from components.interfaces.sockets import CONTROLLER


def test_a_unit_with_fewer_inputs_than_the_socket_offers_fits():
    assert CONTROLLER.problems("unit", BLOCKS["coast"].inputs()[:3], BLOCKS["coast"].outputs()) == []


def test_a_horizon_of_any_length_fits_but_a_second_dimension_does_not():
    plan = variables(CONTROLLER.optional["plan"], {"N_p": 12}, prefix="plan.")
    assert CONTROLLER.problems("unit", [], [*BLOCKS["coast"].outputs(), *plan]) == []
