"""The block decorator and the three kinds of blocks: every refusal, and what the kinds compute."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components import BLOCKS
from components.interfaces.block import Block, Continuous, NoState, Sampled, block
from components.interfaces.buses import Actuation, ObstacleList, VehicleState
from components.interfaces.maths import Array
from components.interfaces.problem import RequestError
from components.interfaces.quantity import integer, quantity
from components.interfaces.record import record
from components.interfaces.sockets import (
    CONTROLLER,
    PLANT,
    TRAFFIC,
    ControllerInputs,
    ControllerOutputs,
    PlantInputs,
    PlantOutputs,
    TrafficInputs,
)


@record
class Knee:
    x: float = quantity("m", "position")
    y: float = quantity("m", "position")
    psi: float = quantity("rad", "angle")
    v_x: float = quantity("m", "a speed in metres")  # wrong unit
    v_y: Array = quantity("m/s", "two speeds", shape=(2,))  # wrong shape
    r: int = integer("a count")  # wrong unit and type


@record
class KneeOutputs:
    state: Knee


@record
class Wind:
    speed: float = quantity("m/s", "speed of the wind")


@record
class WindyInputs:
    actuation: Actuation
    wind: Wind


@record
class WindOutputs:
    wind: Wind


@record
class RichOutputs:
    state: VehicleState
    wind: Wind


@record
class ShortActuation:
    delta_f: float = quantity("rad", "steering")


@record
class ShortOutputs:
    actuation: ShortActuation


def declaring(socket, inputs, outputs) -> str:
    """The text with which a block of these buses is refused."""
    with pytest.raises(RequestError) as caught:

        @block(socket)
        class MyBlock(Block[inputs, NoState, outputs]):
            """For the refusal only."""

    return str(caught.value)


def test_a_missing_output_is_named_with_type_and_unit():
    assert declaring(CONTROLLER, ControllerInputs, ShortOutputs) == (
        "my_block.actuation.T_r: found nothing; valid: an output `actuation.T_r` (Float64 in `N.m`), "
        "as the socket `controller` asks for"
    )


def test_all_missing_outputs_are_named_at_once():
    lines = declaring(PLANT, PlantInputs, WindOutputs).splitlines()
    assert [line.split(":")[0] for line in lines] == [
        f"my_block.state.{name}" for name in ("x", "y", "psi", "v_x", "v_y", "r")
    ]


def test_an_array_that_is_missing_is_named_with_its_shape():
    lines = declaring(TRAFFIC, TrafficInputs, WindOutputs).splitlines()
    assert lines[0] == (
        "my_block.obstacles.valid: found nothing; valid: an output `obstacles.valid` (Boolean in `1` of shape (8)), "
        "as the socket `traffic` asks for"
    )


def test_an_unknown_input_is_refused_with_the_inputs_there_are():
    assert declaring(PLANT, WindyInputs, PlantOutputs) == (
        "my_block.wind.speed: found an input unknown to the socket `plant`; valid: actuation.T_r, actuation.delta_f"
    )


def test_wrong_unit_shape_and_type_are_each_named_with_what_would_fit():
    assert declaring(PLANT, PlantInputs, KneeOutputs).splitlines() == [
        "my_block.state.v_x: found Float64 in `m`; valid: Float64 in `m/s`",
        "my_block.state.v_y: found Float64 in `m/s` of shape (2); valid: Float64 in `m/s`",
        "my_block.state.r: found Int32 in `1`; valid: Float64 in `rad/s`",
    ]


def test_outputs_beyond_the_socket_are_welcome():
    @block(PLANT)
    class WeatherStation(Block[PlantInputs, NoState, RichOutputs]):
        """Plant that also tells the wind. More text."""

    assert [v.name for v in WeatherStation.outputs()][-1] == "wind.speed"
    assert WeatherStation.name == "weather_station"
    assert WeatherStation.summary == "Plant that also tells the wind. More text"


def test_a_block_may_have_another_name_than_its_class():
    @block(PLANT)
    class Meteorology(Block[PlantInputs, NoState, RichOutputs]):
        """Plant under the name that people know."""

        name = "weather"

    @block(PLANT)
    class Forecast(Meteorology):
        """Another block, which does not inherit the name."""

    assert (Meteorology.name, Forecast.name) == ("weather", "forecast")


def test_a_parameter_without_a_quantity_is_refused():
    with pytest.raises(RequestError) as caught:

        @block(PLANT)
        class Bad(Block[PlantInputs, NoState, PlantOutputs]):
            gain: float = 1.0

    assert str(caught.value) == "Bad.gain: found a parameter without a quantity; valid: quantity(unit, description)"


def test_a_block_without_type_arguments_is_refused():
    for base in (Block, Continuous, Sampled):
        with pytest.raises(RequestError) as caught:
            block(PLANT)(type("Bad", (base,), {}))
        assert str(caught.value) == (
            "Bad: found no types for inputs, state and outputs; valid: class X(Continuous[Inputs, State, Outputs])"
        )


@block(CONTROLLER)
class Gain(Sampled[ControllerInputs, NoState, ControllerOutputs]):
    """Controller with one number and one array."""

    N: ClassVar[int] = 2

    k: float = quantity("1", "gain", min=0, max=5)
    taps: Array = quantity("s", "taps", shape=("N",))

    def start(self) -> NoState:
        return NoState()

    def sample(self, x: NoState, u: ControllerInputs) -> tuple[NoState, ControllerOutputs]:
        return x, ControllerOutputs(actuation=Actuation(delta_f=self.k * u.ego.y, T_r=self.taps[0]))


def test_parameters_that_are_missing_or_unknown_are_told_at_once():
    with pytest.raises(RequestError) as caught:
        Gain(tabs=np.zeros(2), k=1.0)
    assert str(caught.value).splitlines() == [
        "gain.tabs: found an unknown field; valid: k, taps. Did you mean `taps`?",
        "gain.taps: found no value; valid: finite number [s]",
    ]


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"k": 5.1}, "gain.k: found 5.1; valid: 0 <= finite number <= 5"),
        ({"k": float("nan")}, "gain.k: found nan; valid: 0 <= finite number <= 5"),
        ({"k": True}, "gain.k: found `True` (true/false); valid: 0 <= finite number <= 5"),
        ({"k": "1"}, "gain.k: found `1` (not a number); valid: 0 <= finite number <= 5"),
        ({"taps": np.zeros(3)}, "gain.taps: found shape (3,); valid: shape (2,)"),
        ({"taps": [0.0, [1.0]]}, "gain.taps: found `[0.0, [1.0]]` (not an array); valid: finite number [s]"),
        (
            {"k": -1.0, "taps": 0.0},
            "gain.k: found -1.0; valid: 0 <= finite number <= 5\ngain.taps: found shape (); valid: shape (2,)",
        ),
    ],
)
def test_wrong_parameter_values_are_all_named_at_construction(values, text):
    with pytest.raises(RequestError) as caught:
        Gain(**{"k": 1.0, "taps": np.zeros(2), **values})
    assert str(caught.value) == text


def test_a_list_counts_like_an_array():
    assert Gain(k=1, taps=[2, 3]).taps.tolist() == [2.0, 3.0]


def test_later_changes_to_a_given_array_do_not_reach_the_block():
    taps = np.ones(2)
    gain = Gain(k=1.0, taps=taps)
    taps[0] = 7.0
    assert gain.taps.tolist() == [1.0, 1.0]


def test_a_block_cannot_be_changed_once_made():
    gain = Gain(k=1.0, taps=np.zeros(2))
    with pytest.raises(dataclasses.FrozenInstanceError):
        gain.k = 2.0


@given(y=st.floats(-10, 10))
def test_a_sampled_block_is_its_sample_seen_from_two_sides(y):
    gain = Gain(k=2.0, taps=np.ones(2))
    empty = np.zeros(8)
    u = ControllerInputs(
        ego=VehicleState(x=0.0, y=y, psi=0.0, v_x=1.0, v_y=0.0, r=0.0),
        obstacles=ObstacleList(valid=empty, id=empty, x=empty, y=empty, psi=empty, v=empty, length=empty, width=empty),
    )
    state = gain.start()
    assert gain.output(state, u).actuation.delta_f == 2.0 * y
    assert gain.step(state, u, 0.1) is gain.sample(state, u)[0]


@block(PLANT)
class Decay(Continuous[PlantInputs, VehicleState, PlantOutputs]):
    """Everything decays at one rate, driven by the torque."""

    k: float = quantity("1", "rate")

    def start(self) -> VehicleState:
        return VehicleState(x=1.0, y=2.0, psi=3.0, v_x=4.0, v_y=5.0, r=6.0)

    def derivative(self, x: VehicleState, u: PlantInputs) -> VehicleState:
        rest = {n: -self.k * getattr(x, n) for n in ("y", "psi", "v_x", "v_y", "r")}
        return VehicleState(x=u.actuation.T_r - self.k * x.x, **rest)

    def output(self, x: VehicleState, u: PlantInputs) -> PlantOutputs:
        return PlantOutputs(state=x)


@given(k=st.floats(-3, 3), h=st.floats(1e-3, 1.0), T_r=st.floats(-5, 5))
def test_one_runge_kutta_step_of_a_linear_equation_is_the_series_up_to_the_fourth_power(k, h, T_r):
    decay = Decay(k=k)
    after = decay.step(decay.start(), PlantInputs(actuation=Actuation(delta_f=0.0, T_r=T_r)), h)
    z = -k * h
    series = 1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24
    assert after.y == pytest.approx(2 * series, rel=1e-12)
    # the held input is integrated with the same series, one power lower
    assert after.x == pytest.approx(series + T_r * h * (1 + z / 2 + z**2 / 6 + z**3 / 24), rel=1e-12, abs=1e-12)


def test_a_continuous_block_is_stepped_by_ten_milliseconds_at_most():
    assert Decay.max_step == 0.01
    assert Gain.max_step == float("inf")


def test_structural_constants_are_the_dimensions_of_a_block():
    assert Gain.dimensions() == {"N": 2}
    assert [v.shape for v in Gain.parameters()] == [(), (2,)]


@pytest.mark.parametrize(
    ("name", "socket"),
    [
        ("bicycle", "plant"),
        ("stationary", "plant"),
        ("ramp_traffic", "traffic"),
        ("empty_road", "traffic"),
        ("mpc", "controller"),
        ("coast", "controller"),
    ],
)
def test_the_catalogue_holds_each_block_under_its_name_in_its_socket(name, socket):
    kind = BLOCKS[name]
    assert (kind.name, kind.socket.name) == (name, socket)
    assert kind.summary
    assert kind.max_step > 0
