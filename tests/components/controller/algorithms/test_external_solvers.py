"""The solvers that run in this process only, on problems with known solutions; `mpc` is the measure in closed loop."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from components.controller.algorithms.external_solvers import interior_point, minimise, sqp
from components.interfaces.maths import Array
from components.interfaces.quantity import quantity
from components.interfaces.record import pack, record
from components.interfaces.staging import symbols


@record
class Bowl:
    """A quadratic around a centre, between -1 and 1."""

    centre: Array = quantity("1", "minimum without bounds", shape=("n",))

    def cost(self, z: Array) -> float:
        return (z[0] - self.centre[0]) * (z[0] - self.centre[0]) + 3 * (z[1] - self.centre[1]) * (z[1] - self.centre[1])

    def bounds(self) -> tuple[Array, Array]:
        return -np.ones(2), np.ones(2)


DIMS = {"n": 2}
SEARCHES = {"sqp": sqp, "interior_point": interior_point}


@pytest.mark.parametrize("search", SEARCHES.values(), ids=SEARCHES)
def test_the_minimum_within_the_bounds_is_found(search):
    found = minimise(search, Bowl(centre=np.array([0.5, 4.0])), DIMS, np.zeros(2), tolerance=1e-9)
    assert found.z == pytest.approx([0.5, 1.0], abs=1e-6)
    assert found.cost == pytest.approx(27.0, abs=1e-4)
    assert found.kkt < 1e-4
    assert found.iterations >= 1


@pytest.mark.parametrize("search", SEARCHES.values(), ids=SEARCHES)
def test_from_what_is_no_number_there_is_no_search(search):
    found = minimise(search, Bowl(centre=np.array([np.nan, 0.0])), DIMS, np.zeros(2), tolerance=1e-9)
    assert np.isnan(found.z).all()
    assert np.isnan(found.cost)
    assert found.iterations == 0


@pytest.mark.parametrize("search", SEARCHES.values(), ids=SEARCHES)
def test_symbols_and_numbers_give_the_same_bits(search):
    column, problem = symbols(Bowl, DIMS, ca.MX, "p")
    z = ca.MX.sym("z", 2)
    graph = minimise(search, problem, DIMS, z, tolerance=1e-9)
    solve = ca.Function("solve", [column, z], [graph.z, graph.cost, graph.kkt, graph.iterations])
    bowl, start = Bowl(centre=np.array([-0.3, -2.0])), np.full(2, 0.1)
    z_found, *rest = solve(pack(bowl), start)
    number = minimise(search, bowl, DIMS, start, tolerance=1e-9)
    assert np.asarray(z_found).ravel().tolist() == number.z.tolist()
    assert [float(v) for v in rest] == [number.cost, number.kkt, number.iterations]
