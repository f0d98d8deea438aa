"""Types and lengths of the buses; names and units of their signals are in `test_sockets.py`."""

from __future__ import annotations

from components.interfaces.buses import SLOTS, WAYPOINTS, SolverStatus
from components.interfaces.record import variables
from components.interfaces.sockets import CONTROLLER, TRAFFIC


def test_types_and_lengths_of_the_obstacles_bus_are_those_of_the_design():
    found = {v.name: (str(v.quantity.type), v.shape) for v in variables(TRAFFIC.outputs["obstacles"])}
    assert found == {
        "valid": ("Boolean", (8,)),
        "id": ("Int32", (8,)),
        **dict.fromkeys(("x", "y", "psi", "v", "length", "width"), ("Float64", (8,))),
    }
    assert (SLOTS, WAYPOINTS) == (8, 15)


def test_the_solver_tells_status_and_iterations_as_enumeration_and_whole_number():
    found = {v.name: str(v.quantity.type) for v in variables(CONTROLLER.optional["solver"])}
    assert found == {"status": "Enumeration", "iterations": "Int32", "cost": "Float64", "kkt": "Float64"}
    assert [item.name for item in SolverStatus] == ["converged", "iteration_limit", "fallback"]
