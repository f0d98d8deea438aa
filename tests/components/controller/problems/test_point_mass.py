"""The planner's point mass: its motion, its prediction by hand, and its solution against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize

from components.controller.algorithms import active_set
from components.controller.problems.ocp import Horizon, Weights
from components.controller.problems.point_mass import PlanningProblem, PointMass

DIMS = {"N_p": 3}
decisions = arrays(float, 6, elements=st.floats(-1, 1))


def problem(*, y_d=(0.4, 0.8, 1.2), weights=(1.0, 0.1, 0.1), v_y=0.0) -> PlanningProblem:
    a_1, b_1, b_2 = weights
    return PlanningProblem(
        weights=Weights(a_1=a_1, b_1=b_1, b_2=b_2, b_3=0.0),
        horizon=Horizon(
            x_d=np.array([2.5, 5.0, 7.5]),
            y_d=np.array(y_d),
            y_upper=np.full(3, 5.25),
            y_lower=np.full(3, -1.75),
        ),
        start=PointMass(x=0.0, y=0.0, v_x=10.0, v_y=v_y),
        dt=0.25,
        a_max=4.905,
    )


def test_a_constant_acceleration_moves_it_as_galilei_says():
    later = PointMass(x=1.0, y=2.0, v_x=10.0, v_y=-1.0).moved(2.0, 4.0, 0.5)
    assert (later.x, later.y, later.v_x, later.v_y) == (6.25, 2.0, 11.0, 1.0)


def test_the_prediction_by_hand():
    z = np.array([1.0, 0.0, -1.0, 0.5, 0.0, 0.0])
    first, second, third = problem(v_y=0.2).prediction(z)
    step = 4.905 * 0.25
    assert (first.v_x, first.v_y) == pytest.approx((10 + step, 0.2 + step / 2))
    assert (first.x, first.y) == pytest.approx(((10 + step) * 0.25, (0.2 + step / 2) * 0.25))
    assert (second.v_x, second.x) == pytest.approx((first.v_x, first.x + first.v_x * 0.25))
    assert (third.v_x, third.y) == pytest.approx((10.0, 3 * first.y))


@given(z=decisions)
def test_the_cost_is_the_distances_of_the_paper_alone(z):
    p = problem()
    total = 0.0
    for i, at in enumerate(p.prediction(z)):
        along = (at.x - p.horizon.x_d[i]) ** 2
        total += along + (at.y - p.horizon.y_d[i]) ** 2
        total += sum(0.1 / max(along + (at.y - edge) ** 2, 1e-3) ** 2 for edge in (5.25, -1.75))
    assert p.cost(z) == pytest.approx(total, rel=1e-12)


@pytest.mark.parametrize("y_d", [(0.1, 0.2, 0.3), (0.4, 0.8, 1.2), (-2.0, -2.0, -2.0), (1.0, 0.0, -1.0)])
def test_the_solution_is_that_of_scipy(y_d):
    p = problem(y_d=y_d)
    found = active_set.minimise(p, DIMS, np.zeros(6), iterations=10, tolerance=1e-6)
    assert found.kkt < 1e-6
    other = minimize(p.cost, np.zeros(6), method="L-BFGS-B", bounds=[(-1, 1)] * 6, options={"ftol": 1e-15})
    assert found.cost == pytest.approx(other.fun, rel=1e-7)
    assert found.z == pytest.approx(other.x, abs=1e-3)


def test_without_boundaries_a_reachable_path_is_met_exactly():
    p = problem(y_d=(0.05, 0.15, 0.3), weights=(1.0, 0.0, 0.0))
    found = active_set.minimise(p, DIMS, np.zeros(6), iterations=10, tolerance=1e-6)
    states = p.prediction(found.z)
    assert [s.x for s in states] == pytest.approx([2.5, 5.0, 7.5], abs=1e-6)
    assert [s.y for s in states] == pytest.approx([0.05, 0.15, 0.3], abs=1e-6)
