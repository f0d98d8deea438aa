"""Solvers of bounded problems that do not become C and run in this process only.

Each is a CasADi callback, so that it takes the place of `active_set` in the same equations. Tolerances and limits
mirror those of MATLAB's fmincon where they are known (optimality 1e-6, quasi-Newton Hessian for interior point).
"""
# pyright: basic
# CasADi and scipy.optimize carry few types here; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import casadi as ca
import numpy as np

from components.controller.algorithms.bounded import BoundedProblem, Dimensions, Solution, solution, symbolic
from components.interfaces.callback import Callback
from components.interfaces.maths import Array
from components.interfaces.record import pack

Search = Callable[["_NumericProblem", Array, Array, float], tuple[Array, int]]
"""``search(problem, z_start, data, tolerance) -> z, iterations``"""

INTERIOR_POINT_ITERATIONS = 1000
SQP_ITERATIONS = 400


class _NumericProblem:
    """Cost with its gradient, and bounds, as functions of numbers: the decision z and the column of data."""

    def __init__(self, kind: type, dimensions: Dimensions, n: int) -> None:
        self.symbolic = symbolic(kind, dimensions, n)
        z, data, J = self.symbolic.z, self.symbolic.data, self.symbolic.cost
        self.cost = ca.Function("cost", [z, data], [J, ca.gradient(J, z)])
        self.bounds = ca.Function("bounds", [data], [self.symbolic.lower, self.symbolic.upper])


def interior_point(problem: _NumericProblem, z_start: Array, data: Array, tolerance: float) -> tuple[Array, int]:
    """IPOPT with a limited-memory quasi-Newton Hessian."""
    solver = _ipopt(problem, tolerance)
    lower, upper = problem.bounds(data)
    z = np.array(solver(x0=z_start, p=data, lbx=lower, ubx=upper)["x"]).ravel()
    return z, int(solver.stats()["iter_count"])


@cache
def _ipopt(problem: _NumericProblem, tolerance: float) -> ca.Function:
    options = {
        "print_time": False,
        "calc_lam_p": False,
        "show_eval_warnings": False,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "tol": tolerance,
            "max_iter": INTERIOR_POINT_ITERATIONS,
            "hessian_approximation": "limited-memory",
        },
    }
    nlp = {"x": problem.symbolic.z, "p": problem.symbolic.data, "f": problem.symbolic.cost}
    return ca.nlpsol("interior_point", "ipopt", nlp, options)


def sqp(problem: _NumericProblem, z_start: Array, data: Array, tolerance: float) -> tuple[Array, int]:
    """Sequential quadratic programming by SLSQP; `tolerance` is on the change of the objective."""
    from scipy.optimize import minimize  # noqa: PLC0415 - slow to import, and only this needs it

    def value_and_slope(z: Array) -> tuple[float, Array]:
        value, slope = problem.cost(z, data)
        return float(value), np.array(slope).ravel()

    lower, upper = (np.array(b).ravel() for b in problem.bounds(data))
    result = minimize(
        value_and_slope,
        np.clip(z_start, lower, upper),
        jac=True,
        method="SLSQP",
        bounds=list(zip(lower, upper, strict=True)),
        options={"ftol": tolerance, "maxiter": SQP_ITERATIONS},
    )
    return np.asarray(result.x), int(result.nit)


def _searched(
    problem: _NumericProblem, search: Search, z_start: Array, data: Array, tolerance: Array
) -> tuple[Array, int]:
    """The result of a search, in plain numbers; NaN, without a search, where a given value is not finite."""
    if not (np.isfinite(z_start).all() and np.isfinite(data).all()):
        return np.full(z_start.size, np.nan), 0
    return search(problem, z_start, data, float(tolerance[0]))


@cache
def _callback(search: Search, kind: type, dimensions: Dimensions, n: int) -> Callback:
    """A search as a node of the equations: ``(z_start, data, tolerance) -> (z, iterations)``."""
    problem = _NumericProblem(kind, dimensions, n)
    sizes = [n, problem.symbolic.data.numel(), 1]
    return Callback(search.__name__, partial(_searched, problem, search), sizes, [n, 1])


def minimise(
    search: Search, problem: BoundedProblem, dimensions: dict[str, int], z_start: Array, *, tolerance: float
) -> Solution:
    """Minimise ``problem.cost(z)`` within ``problem.bounds()`` by `search`.

    Args:
        search: `interior_point` or `sqp`.
        problem: A record of numbers or of graph symbols.
        dimensions: The structural constants that give the lengths of its arrays.
        z_start: Where the search begins, of shape (n,).
        tolerance: The tolerance at which the search stops, by its own criterion.

    Returns:
        The solution, in numbers or graph symbols as the problem is; NaN where a value given was not finite.
    """
    kind, key = type(problem), tuple(dimensions.items())
    data: Any = pack(problem)
    z, iterations = _callback(search, kind, key, z_start.shape[0])(z_start, data, tolerance)
    return solution(kind, key, data, z, iterations)
