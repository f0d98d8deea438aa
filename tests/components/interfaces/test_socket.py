"""What fits a socket, what does not and in which words, and what a socket knows of its buses."""

from __future__ import annotations

import pytest

from components import BLOCKS
from components.interfaces.quantity import Quantity, Type, boolean, quantity
from components.interfaces.record import Variable, record, variables
from components.interfaces.socket import ANY_LENGTH, BusTraits, Position, Reading, Socket, describe
from components.interfaces.sockets import CONTROLLER


@record
class Command:
    """What is asked for."""

    angle: float = quantity("rad", "angle")
    on: bool = boolean("whether it is on")


@record
class Movement:
    """What it does."""

    speed: float = quantity("m/s", "speed")
    trace: float = quantity("m", "trace", shape=("N",))


DOOR = Socket(
    name="door",
    inputs={"command": Command},
    outputs={"motion": Movement},
    optional={"mood": Command},
    traits={"command": BusTraits(driven_by="person.command", must_read=Reading.EVERYTHING)},
)
COMMAND = list(variables(Command, prefix="command."))
MOTION = list(variables(Movement, {"N": 3}, prefix="motion."))


def messages(inputs, outputs):
    return [str(problem) for problem in DOOR.problems("left", inputs, outputs)]


def like(variable, **changes):
    """The variable with another quantity."""
    q = variable.quantity
    facts = {"unit": q.unit, "description": "", "type": q.type, "shape": q.shape, **changes}
    return Variable(variable.name, Quantity(**facts))


def test_a_unit_with_just_the_buses_fits():
    assert messages(COMMAND, MOTION) == []
    assert messages([], MOTION) == []
    assert messages(COMMAND, [*MOTION, *variables(Command, prefix="mood."), *variables(Command, prefix="own.")]) == []


def test_what_is_missing_is_told_with_what_it_should_be():
    assert messages(COMMAND, []) == [
        "left.motion.speed: found nothing; valid: an output `motion.speed` (Float64 in `m/s`), "
        "as the socket `door` asks for",
        "left.motion.trace: found nothing; valid: an output `motion.trace` (Float64 in `m` of shape (any)), "
        "as the socket `door` asks for",
    ]


def test_an_input_of_its_own_is_told():
    assert messages([*COMMAND, *variables(Command, prefix="wind.")[:1]], MOTION) == [
        "left.wind.angle: found an input unknown to the socket `door`; valid: command.angle, command.on"
    ]


def test_a_wrong_unit_type_or_shape_is_told_with_both_sides():
    angle, on = COMMAND
    speed, trace = MOTION
    assert messages([like(angle, unit="deg"), like(on, type=Type.INT32)], [like(speed, shape=(2,)), trace]) == [
        "left.command.angle: found Float64 in `deg`; valid: Float64 in `rad`",
        "left.command.on: found Int32 in `1`; valid: Boolean in `1`",
        "left.motion.speed: found Float64 in `m/s` of shape (2); valid: Float64 in `m/s`",
    ]


def test_a_quantity_without_a_unit_of_measurement_fits():
    assert messages([like(COMMAND[0], unit=""), COMMAND[1]], MOTION) == []


def test_an_optional_bus_has_to_be_right_where_it_is_shown():
    assert messages(COMMAND, [*MOTION, Variable("mood.angle", Quantity("m", ""))]) == [
        "left.mood.angle: found Float64 in `m`; valid: Float64 in `rad`"
    ]


def test_lengths_that_depend_on_the_block_are_open():
    (trace,) = [v for v in DOOR.required() if v.name == "motion.trace"]
    assert trace.quantity.shape == (ANY_LENGTH,)
    two = like(MOTION[1], shape=(2, 2))
    assert messages(COMMAND, [MOTION[0], two]) == [
        "left.motion.trace: found Float64 in `m` of shape (2, 2); valid: Float64 in `m` of shape (any)"
    ]


def test_signals_are_told_by_what_is_done_with_them():
    def names(role=None):
        return [v.name for v in DOOR.signals(role)]

    assert names("inputs") == ["command.angle", "command.on"]
    assert names("outputs") == ["motion.speed", "motion.trace", "mood.angle", "mood.on"]
    assert names() == [*names("inputs"), *names("outputs")]
    assert DOOR.buses == {"command": Command, "motion": Movement, "mood": Command}


def test_a_bus_is_known_by_its_name_or_by_one_of_its_signals():
    assert DOOR.bus("command") is DOOR.bus("command.angle") is DOOR.traits["command"]
    assert DOOR.bus("motion.speed") == BusTraits()
    assert DOOR.wiring == {"door.command": "person.command"}
    assert CONTROLLER.bus("ego").position is Position.VEHICLE


@pytest.mark.parametrize(
    ("declared", "text"),
    [
        (Quantity("m", ""), "Float64 in `m`"),
        (Quantity("", ""), "Float64 without a unit"),
        (Quantity("", "", Type.INT32), "Int32"),
        (Quantity("1", "", Type.BOOLEAN, (2, ANY_LENGTH)), "Boolean in `1` of shape (2, any)"),
    ],
)
def test_a_quantity_reads_as_type_unit_and_shape(declared, text):
    assert describe(declared) == text


def test_a_unit_with_fewer_inputs_than_the_socket_offers_fits():
    assert CONTROLLER.problems("unit", BLOCKS["coast"].inputs()[:3], BLOCKS["coast"].outputs()) == []


def test_a_horizon_of_any_length_fits_but_a_second_dimension_does_not():
    plan = variables(CONTROLLER.optional["plan"], {"N_p": 12}, prefix="plan.")
    assert CONTROLLER.problems("unit", [], [*BLOCKS["coast"].outputs(), *plan]) == []
