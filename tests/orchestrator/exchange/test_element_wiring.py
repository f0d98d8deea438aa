"""The wiring of a system element by element gives the same system again, and others where units are exchanged."""

from __future__ import annotations

from dataclasses import replace

import pytest

from components.interfaces.conversion import IDENTITY, Linear, Lookup
from orchestrator.exchange.element_wiring import Feed, Place, rewired, wiring_of
from orchestrator.loading import load
from orchestrator.scenario.options import Options


@pytest.fixture
def system():
    """The static scenario, whose obstacles are arrays."""
    return load("static", Options(mode="blocks")).system


def test_a_system_comes_back_as_it_is(system):
    again = rewired(system, system.units, wiring_of(system), ())
    assert again.connections == system.connections
    assert (again.held, again.unset, again.sockets) == (system.held, system.unset, system.sockets)
    assert not again.transformations
    assert again.wiring["controller.obstacles.x"] == "traffic.obstacles.x", "arrays stay whole"


def test_elements_of_an_array_are_driven_one_by_one_or_hold_a_value(system):
    wiring = wiring_of(system)
    wiring[Place("controller", "obstacles.x", 1)] = Feed(None, 7.5)
    wiring[Place("controller", "obstacles.x", 2)] = Feed(
        Place("traffic", "obstacles.y", 5), conversion=Linear(2.0, 1.0)
    )
    del wiring[Place("controller", "obstacles.x", 3)]
    made = rewired(system, system.units, wiring, ())
    assert made.wiring["controller.obstacles.x[1]"] == "traffic.obstacles.x[1]"
    assert made.wiring["controller.obstacles.x[3]"] == "traffic.obstacles.y[6]"
    assert made.transformations == {"controller.obstacles.x[3]": Linear(2.0, 1.0)}
    assert made.held["controller.obstacles.x"] == [0.0, 7.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert not {"controller.obstacles.x", "controller.obstacles.x[2]", "controller.obstacles.x[4]"} & made.wiring.keys()
    assert wiring_of(made)[Place("controller", "obstacles.x", 2)] == wiring[Place("controller", "obstacles.x", 2)]


def test_an_input_that_nobody_has_a_value_for_is_not_set(system):
    wiring = {end: drive for end, drive in wiring_of(system).items() if end.variable != "ego.x"}
    assert rewired(system, system.units, wiring, ()).unset == {"controller.ego.x", "traffic.ego.x"}


def test_a_unit_that_is_exchanged_leaves_its_socket(system):
    units = {**system.units, "traffic": replace(system.units["traffic"])}
    assert rewired(system, units, wiring_of(system), ()).sockets.keys() == {"plant", "controller"}


def test_conversions_are_joined_in_their_order():
    drive = Feed(Place("a", "y"), conversion=Linear(2.0, 1.0))
    assert drive.then(Linear(10.0, 0.5)).conversion == Linear(20.0, 10.5)
    assert drive.after(Place("b", "z"), Linear(10.0, 0.5)) == Feed(Place("b", "z"), conversion=Linear(20.0, 2.0))
    assert drive.constant(3.0) == Feed(None, 7.0)
    assert Feed(None, 3.0).then(Linear(2.0, 1.0)) == Feed(None, 7.0)
    table = Feed(Place("a", "y"), conversion=Lookup({1: 2}))
    assert table.then(IDENTITY) is table
    assert table.after(Place("b", "z"), IDENTITY).conversion == Lookup({1: 2})
    assert table.constant(1) == Feed(None, 2)
    assert Feed(Place("a", "y")).constant(value=True).value is True
