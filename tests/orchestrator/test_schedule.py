"""The order of one macro step follows from what depends on what."""

from __future__ import annotations

from typing import final

import pytest

from components.interfaces.block import Block, NoState, Sampled, block
from components.interfaces.problem import RequestError
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from orchestrator.master import simulate
from orchestrator.scenario import Options, prepare
from orchestrator.schedule import sequential
from orchestrator.system import System, block_source

ANY = Socket(name="any", inputs={}, outputs={}, optional={})


@record
class Signal:
    """One number."""

    value: float = quantity("1", "a number")


@record
class In:
    """One input bus."""

    a: Signal


@record
class Out:
    """One output bus."""

    b: Signal


@final
@block(Socket(name="any", inputs={"a": Signal}, outputs={}, optional={}))
class Gain(Block[In, NoState, Out]):
    """Shows twice its input at once."""

    k: float = quantity("1", "gain")

    def start(self):
        return NoState()

    def output(self, x, u):
        return Out(b=Signal(value=self.k * u.a.value))

    def step(self, x, u, h):
        return x


@final
@block(Socket(name="any", inputs={"a": Signal}, outputs={}, optional={}))
class Sum(Block[In, Signal, Out]):
    """Shows the sum of its inputs so far."""

    def start(self):
        return Signal(value=1.0)

    def output(self, x, u):
        return Out(b=x)

    def step(self, x, u, h):
        return Signal(value=x.value + u.a.value)


@final
@block(Socket(name="any", inputs={"a": Signal}, outputs={}, optional={}))
class Held(Sampled[In, Signal, Out]):
    """Shows its input and how often it sampled."""

    def start(self):
        return Signal(value=0.0)

    def sample(self, x, u):
        count = Signal(value=x.value + 1)
        return count, Out(b=Signal(value=u.a.value + 1000 * count.value))


def system(units, wiring):
    return System({name: block_source(b) for name, b in units.items()}, wiring)


def test_the_controller_acts_at_once_and_the_plant_shows_its_tyres_with_the_new_actuation():
    schedule = sequential(prepare("static", Options(mode="blocks")).system)
    assert str(schedule) == (
        "set controller; step controller; get controller; set plant; get plant;"
        " set traffic; step traffic; step plant; get traffic; get plant"
    )


@pytest.mark.parametrize("names", [("sum", "gain", "held"), ("held", "gain", "sum"), ("gain", "held", "sum")])
def test_no_delay_whatever_the_order_of_the_units(names):
    made = {"sum": Sum(), "gain": Gain(k=2.0), "held": Held()}
    wiring = {"gain.a": "sum.b", "held.a": "gain.b", "sum.a": "gain.b"}
    frame = simulate(system({n: made[n] for n in names}, wiring), h=0.5, until=2.0)
    assert frame["sum.b.value"].tolist() == [1, 3, 9, 27, 81]
    assert frame["gain.b.value"].tolist() == [2, 6, 18, 54, 162]
    assert frame["held.b.value"].tolist() == [1002, 2006, 3018, 4054, 5162]


def test_an_algebraic_loop_is_shown_as_its_chain():
    units = {"p": Gain(k=1.0), "q": Held(), "s": Sum()}
    with pytest.raises(RequestError) as error:
        sequential(system(units, {"p.a": "q.b", "q.a": "p.b", "s.a": "p.b"}))
    text = str(error.value)
    assert text.startswith("algebraic loop: found ")
    assert "p.b.value -> q.a.value" in text
    assert "q.b.value -> p.a.value" in text
    assert "Break it with a unit whose output does not depend on its input" in text


def test_a_unit_fed_by_itself_is_a_loop():
    with pytest.raises(RequestError, match="algebraic loop: found g.b.value -> g.a.value"):
        sequential(system({"g": Gain(k=1.0)}, {"g.a": "g.b"}))


def test_a_loop_through_a_state_is_none():
    frame = simulate(system({"s": Sum(), "g": Gain(k=1.0)}, {"s.a": "g.b", "g.a": "s.b"}), h=1.0, until=3.0)
    assert frame["s.b.value"].tolist() == [1, 2, 4, 8]
