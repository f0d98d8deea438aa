"""Elements of arrays are connected one by one, with units and tables of their own."""

from __future__ import annotations

from typing import final

import pytest

from components.interfaces.block import Block, NoState, block
from components.interfaces.conversion import Linear, Lookup
from components.interfaces.maths import Array
from components.interfaces.problem import RequestError
from components.interfaces.quantity import boolean, integer, quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from orchestrator.stepping.master import Simulation
from orchestrator.system.source import InProcess
from orchestrator.system.system import System


@record
class Bus:
    """One of each."""

    x: Array = quantity("m", "lengths", shape=(3,))
    v: float = quantity("m/s", "a speed")
    n: Array = integer("counts", shape=(2,))
    on: bool = boolean("a switch")


@record
class Out:
    """What is shown."""

    b: Bus


@record
class In:
    """What is read."""

    a: Bus


ANY = Socket(name="any", inputs={"a": Bus}, outputs={}, optional={})


@final
@block(ANY)
class Giver(Block[NoState, NoState, Out]):
    """Shows parameters."""

    x: Array = quantity("m", "lengths", shape=(3,))
    v: float = quantity("m/s", "a speed")
    n: Array = integer("counts", shape=(2,))

    def start(self):
        return NoState()

    def output(self, x, u):
        return Out(b=Bus(x=self.x, v=self.v, n=self.n, on=True))

    def step(self, x, u, h):
        return x


@final
@block(ANY)
class Taker(Block[In, NoState, Out]):
    """Shows what it reads."""

    def start(self):
        return NoState()

    def output(self, x, u):
        return Out(b=u.a)

    def step(self, x, u, h):
        return x


UNITS = {"g": InProcess(Giver, {"x": [1.0, 2.0, 3.0], "v": 7.0, "n": [4, 5]}), "t": InProcess(Taker, {})}
HELD = {"t.a.x": [10.0, 20.0, 30.0], "t.a.v": 0.5, "t.a.n": [8, 9], "t.a.on": False}


def row(wiring, **changed):
    held = {path: value for path, value in HELD.items() if path not in wiring}
    with Simulation(System(UNITS, wiring, held, **changed), h=0.1, until=0.0) as simulation:
        simulation.run()
        frame = simulation.frame()
    return {name[4:]: frame[name][0] for name in frame if name.startswith("t.b.")}


def problems(wiring, **changed):
    held = {path: value for path, value in HELD.items() if path not in wiring}
    with pytest.raises(RequestError) as error:
        System(UNITS, wiring, {**held, **changed.pop("held", {})}, **changed)
    return str(error.value).splitlines()


def test_elements_come_from_elsewhere_and_the_others_keep_their_held_values():
    wiring = {"t.a.x[3]": "g.b.x[1]", "t.a.x[1]": "g.b.x[3]", "t.a.v": "g.b.v", "t.a.n[2]": "g.b.n[1]"}
    assert row(wiring) == {
        "x[1]": 3.0, "x[2]": 20.0, "x[3]": 1.0, "v": 7.0, "n[1]": 8, "n[2]": 4, "on": False
    }  # fmt: skip


def test_elements_are_transformed_each_for_itself():
    wiring = {"t.a.x[1]": "g.b.x[1]", "t.a.x[2]": "g.b.x[2]", "t.a.n[1]": "g.b.n[1]", "t.a.on": "g.b.on"}
    changes = {"t.a.x[2]": Linear(10.0, 0.5), "t.a.n[1]": Lookup({4: -4}), "t.a.on": Lookup({True: False})}
    found = row(wiring, transformations=changes)
    assert (found["x[1]"], found["x[2]"], found["x[3]"], found["n[1]"], found["on"]) == (1.0, 20.5, 30.0, -4, False)


def test_numbers_pass_unconverted_where_that_is_asked_for():
    assert problems({"t.a.x[2]": "g.b.v"}) == [
        "g.b.v -> t.a.x[2]: found Float64 in `m/s`; valid: Float64 in `m`",
    ]
    assert row({"t.a.x[2]": "g.b.v"}, unconverted={"t.a.x[2]"})["x[2]"] == 7.0


def test_a_written_array_replaces_all_elements_and_shows_what_each_received():
    wiring = {"t.a.x[2]": "g.b.x[3]"}
    held = {path: value for path, value in HELD.items() if path not in wiring}
    system = System(UNITS, wiring, held, transformations={"t.a.x[2]": Linear(2.0)})
    with Simulation(system, h=0.1, until=0.3) as simulation:
        simulation.step()
        simulation.write("t.a.x", [7.0, 8.0, 9.0])
        simulation.step()
        simulation.release("t.a.x")
        simulation.run()
        frame = simulation.frame()
    assert frame["t.b.x[2]"].tolist() == [6.0, 8.0, 6.0, 6.0]
    assert frame["t.a.x[2]"].tolist() == [6.0, 8.0, 6.0, 6.0]


def test_what_does_not_go_together_is_refused():
    assert problems({"t.a.x[2]": "g.b.x"}) == [
        "g.b.x -> t.a.x[2]: found Float64 in `m` of shape (3); valid: Float64 in `m`"
    ]
    assert problems({"t.a.x": "g.b.x", "t.a.x[2]": "g.b.x[1]"}) == [
        "t.a.x: found two sources, g.b.x and g.b.x[1]; valid: one source"
    ]
    assert problems({"t.a.x[2]": "g.b.x[1]", "t.a.x": "g.b.x"}) == [
        "t.a.x[2]: found two sources, g.b.x[1] and g.b.x; valid: one source"
    ]
    assert problems({"t.a.x[4]": "g.b.x[1]"})[0].startswith("t.a.x[4]: found no such input")
    assert problems({"t.a.v": "g.b.x[0]"})[0].startswith("g.b.x[0]: found no such output")
    assert problems({"t.a.on": "g.b.on"}, transformations={"t.a.on": Lookup({True: 3})}) == [
        "g.b.on -> t.a.on, transformation: found `3` (whole number); valid: true or false"
    ]
    assert problems({"t.a.n[1]": "g.b.on"}, transformations={"t.a.n[1]": Lookup({1: 3})}) == [
        "g.b.on -> t.a.n[1]: found Boolean in `1`; valid: Int32 in `1`"
    ]


def test_elements_without_a_source_are_named():
    with pytest.raises(RequestError) as error:
        System(UNITS, {"t.a.x[2]": "g.b.x[1]"}, {p: v for p, v in HELD.items() if p != "t.a.x"})
    assert str(error.value) == (
        "t.a.x: found no source of a.x[1], a.x[3]; valid: a connection or a held value. Connect it, or give it a value."
    )
