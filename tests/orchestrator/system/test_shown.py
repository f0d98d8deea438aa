"""Which bus of a system shows what, whatever its units and sockets are called."""

from __future__ import annotations

from dataclasses import replace

from components.interfaces.buses import Actuation, Motion, ObstacleList, Plan, Solver, Tyre, VehicleState, Waypoints
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.shown import shown, signal_path, unit_that_shows
from orchestrator.system.system import System


def test_each_output_bus_is_found_by_its_record():
    system = prepare("static", Options(mode="blocks")).system
    assert shown(system) == {
        VehicleState: "plant.state",
        Tyre: "plant.tyre",
        Motion: "plant.motion",
        ObstacleList: "traffic.obstacles",
        Actuation: "controller.actuation",
        Waypoints: "controller.path",
        Plan: "controller.plan",
        Solver: "controller.solver",
    }


def test_a_system_without_sockets_shows_nothing():
    system = prepare("static", Options(mode="blocks")).system
    buses = shown(System(units=system.units, wiring=system.wiring))
    assert buses == {}
    assert unit_that_shows(buses, VehicleState) is None
    assert not signal_path(buses, VehicleState, "x").startswith("plant")


def test_of_several_units_in_a_socket_the_first_counts():
    system = prepare("static", Options(mode="blocks")).system
    units = {"second": system.units["plant"], **system.units}
    held = {f"second.actuation.{name}": 0.0 for name in ("delta_f", "T_r")}
    sockets = system.sockets | {"second": system.sockets["plant"]}
    both = replace(system, units=units, sockets=sockets, held={**system.held, **held})
    assert shown(both)[VehicleState] == "plant.state"
    assert unit_that_shows(shown(both), Tyre) == "plant"
    turned = replace(both, sockets=dict(reversed(sockets.items())))
    assert shown(turned)[VehicleState] == "second.state"


@record
class Gaze:
    """Where a person looks."""

    yaw: float = quantity("rad", "angle of the head, to the left")


def test_the_buses_of_another_socket_are_found_as_well():
    system = prepare("static", Options(mode="blocks")).system
    plant = system.sockets["plant"]
    other = replace(plant, name="other", optional={**plant.optional, "gaze": Gaze})
    buses = shown(replace(system, sockets=system.sockets | {"plant": other}))
    assert signal_path(buses, Gaze, "yaw") == "plant.gaze.yaw"
    assert buses[VehicleState] == "plant.state"
