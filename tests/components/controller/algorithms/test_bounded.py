"""The residual of the optimality conditions, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from components.controller.algorithms.bounded import solution
from components.interfaces.maths import Array
from components.interfaces.quantity import quantity
from components.interfaces.record import record


@record
class Slope:
    """A plane over the square from -1 to 1."""

    g: Array = quantity("1", "slope", shape=("n",))

    def cost(self, z: Array) -> float:
        return self.g[0] * z[0] + self.g[1] * z[1]

    def bounds(self) -> tuple[Array, Array]:
        return -np.ones(2), np.ones(2)


@pytest.mark.parametrize(
    ("z", "kkt"),
    [
        ((0.0, 0.0), 0.5),  # both move against the slope, as far as it is steep
        ((-0.75, 0.0), 0.25),  # the bound stops the first
        ((-1.0, 1.0), 0.0),  # the corner: the optimum
        ((1.0, 1.0), 0.5),  # on a bound, but on the wrong one
    ],
)
def test_the_residual_is_how_far_a_projected_gradient_step_moves(z, kkt):
    found = solution(Slope, (("n", 2),), np.array([0.5, -0.125]), np.array(z), 3.0)
    assert found.kkt == pytest.approx(kkt, abs=1e-15)
    assert found.cost == pytest.approx(0.5 * z[0] - 0.125 * z[1], abs=1e-15)
    assert (found.z.tolist(), found.iterations) == (list(z), 3.0)
