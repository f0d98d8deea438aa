"""Trajectory optimisation by stages, against problems whose solution is known."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.optimize import minimize

from components.controller.algorithms import ilqr
from components.interfaces.maths import sin
from components.interfaces.quantity import quantity
from components.interfaces.record import record

N = 12


@record
class Nothing:
    """No stage data but one number."""

    target: float = quantity("1", "where to be")


@record
class Limits:
    """Weights and bounds."""

    weight: float = quantity("1", "weight of the input")
    most: float = quantity("1", "largest input")
    k: float = quantity("1", "strength of the nonlinearity")


@record
class Position:
    """A point mass on a line."""

    x: float = quantity("1", "position")
    v: float = quantity("1", "speed")


@record
class Force:
    """Two forces, of which the second is twice as strong."""

    a: float = quantity("1", "first")
    b: float = quantity("1", "second")


def step(p, x, u):
    return Position(x=x.x + 0.1 * x.v, v=x.v + 0.1 * (u.a + 2 * u.b - p.k * sin(x.x)))


def residual(p, stage, x, u):
    return [x.x - stage.target, 0.1 * x.v, p.weight * u.a, p.weight * u.b]


def bounds(p):
    return Force(a=-p.most, b=-p.most), Force(a=p.most, b=p.most)


STAGES = ilqr.Stages(Limits, Nothing, Position, Force, step, residual, bounds)


def solve(*, most, k=0.0, iterations=1, target=0.0, start=(1.0, 0.0), n=N):
    limits = Limits(weight=0.3, most=most, k=k)
    data = np.full(n + 1, target)
    now = Position(x=start[0], v=start[1])
    return ilqr.optimise(STAGES, limits, data, now, np.zeros(2 * n), N=n, iterations=iterations)


def total(u, *, k, target=0.0, start=(1.0, 0.0), n=N):
    x, cost = np.array(start), 0.0
    for a, b in u.reshape(n, 2):
        cost += (x[0] - target) ** 2 + 0.01 * x[1] ** 2 + 0.09 * (a * a + b * b)
        x = np.array([x[0] + 0.1 * x[1], x[1] + 0.1 * (a + 2 * b - k * np.sin(x[0]))])
    return cost + (x[0] - target) ** 2 + 0.01 * x[1] ** 2


def reference(most, **problem):
    found = minimize(
        total_of(problem),
        np.zeros(2 * N),
        bounds=[(-most, most)] * (2 * N),
        method="L-BFGS-B",
        options={"ftol": 1e-15, "gtol": 1e-10, "maxiter": 5000},
    )
    return found.x, found.fun


def total_of(problem):
    return lambda u: total(u, **problem)


def test_a_linear_problem_without_bounds_is_solved_in_one_iteration():
    found = solve(most=1e6)
    u, cost = reference(1e6, k=0.0)
    assert found.cost == pytest.approx(cost, rel=1e-9)
    np.testing.assert_allclose(found.u, u, atol=1e-4)


def test_with_a_long_horizon_the_first_input_is_that_of_the_riccati_equation():
    n = 200
    A, B = np.array([[1, 0.1], [0, 1]]), np.array([[0, 0], [0.1, 0.2]])
    Q, R = np.diag([1, 0.01]), 0.09 * np.eye(2)
    P = solve_discrete_are(A, B, Q, R)
    K = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    np.testing.assert_allclose(solve(most=1e6, n=n).u[:2], -K @ [1.0, 0.0], rtol=1e-6)


@pytest.mark.parametrize("k", [0.0, 3.0])
def test_bounds_and_nonlinear_steps_are_met(k):
    found = solve(most=0.4, k=k, iterations=20, target=0.5)
    _, cost = reference(0.4, k=k, target=0.5)
    assert np.abs(found.u).max() <= 0.4 + 1e-12
    assert found.cost == pytest.approx(cost, rel=1e-3)
    assert found.cost == pytest.approx(total(found.u, k=k, target=0.5), rel=1e-12)


def test_the_cost_never_rises():
    costs = [solve(most=0.4, k=8.0, iterations=i, start=(2.0, -1.0)).cost for i in range(1, 8)]
    assert all(after <= before for before, after in pairwise(costs))
