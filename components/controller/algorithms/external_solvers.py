"""The same optimal control problem for solvers that do not become C: they run in this process only.

Each is a CasADi callback, so that it takes the place of `active_set` in the same equations. Tolerances and limits
mirror those of MATLAB's fmincon where they are known (optimality 1e-6, quasi-Newton Hessian for interior point).
"""
# pyright: basic
# CasADi and scipy.optimize carry few types here; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from components.controller.algorithms.active_set import Solution, residual_function
from components.interfaces.callback import Callback
from components.interfaces.maths import Array, is_symbolic
from components.interfaces.record import pack
from components.interfaces.staging import symbols

P = TypeVar("P")
Search = Callable[["_Given", Array, Array, float], tuple[Array, int]]
"""``search(problem, z_start, data, tolerance) -> z, iterations``"""

INTERIOR_POINT_ITERATIONS = 1000
SQP_ITERATIONS = 400


class _Given:
    """Cost, gradient and bounds of a problem as functions of the decision z and the column of its data."""

    def __init__(self, cost: Any, bounds: Any, kind: type, dimensions: dict[str, int], n: int) -> None:
        self.data, problem = symbols(kind, dimensions, name="data")
        self.z = ca.SX.sym("z", n)
        self.J = cost(problem, self.z)
        self.cost = ca.Function("cost", [self.z, self.data], [self.J, ca.gradient(self.J, self.z)])
        self.bounds = ca.Function("bounds", [self.data], list(bounds(problem)))


def interior_point(given: _Given, z_start: Array, data: Array, tolerance: float) -> tuple[Array, int]:
    """IPOPT with a limited-memory quasi-Newton Hessian."""
    solver = _ipopt(given, tolerance)
    lower, upper = given.bounds(data)
    z = np.array(solver(x0=z_start, p=data, lbx=lower, ubx=upper)["x"]).ravel()
    return z, int(solver.stats()["iter_count"])


@cache
def _ipopt(given: _Given, tolerance: float) -> ca.Function:
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
    return ca.nlpsol("interior_point", "ipopt", {"x": given.z, "p": given.data, "f": given.J}, options)


def sqp(given: _Given, z_start: Array, data: Array, tolerance: float) -> tuple[Array, int]:
    """Sequential quadratic programming by SLSQP; `tolerance` is on the change of the objective."""
    from scipy.optimize import minimize  # noqa: PLC0415 - slow to import, and only this needs it

    def value_and_slope(z: Array) -> tuple[float, Array]:
        value, slope = given.cost(z, data)
        return float(value), np.array(slope).ravel()

    lower, upper = (np.array(b).ravel() for b in given.bounds(data))
    found = minimize(
        value_and_slope,
        np.clip(z_start, lower, upper),
        jac=True,
        method="SLSQP",
        bounds=list(zip(lower, upper, strict=True)),
        options={"ftol": tolerance, "maxiter": SQP_ITERATIONS},
    )
    return np.asarray(found.x), int(found.nit)


def _searched(given: _Given, search: Search, z_start: Array, data: Array, tolerance: Array) -> tuple[Array, int]:
    """A search from plain numbers; none from what is not finite."""
    if not (np.isfinite(z_start).all() and np.isfinite(data).all()):
        return np.full(z_start.size, np.nan), 0
    return search(given, z_start, data, float(tolerance[0]))


@cache
def _callback(  # noqa: PLR0913 - what makes two problems the same
    search: Search, cost: Any, bounds: Any, kind: type, dimensions: Any, n: int
) -> Callback:
    """A search as a node of the equations: ``(z_start, data, tolerance) -> (z, iterations)``."""
    given = _Given(cost, bounds, kind, dict(dimensions), n)
    return Callback(search.__name__, partial(_searched, given, search), [n, given.data.numel(), 1], [n, 1])


def minimise(  # noqa: PLR0913 - as `active_set.minimise`
    search: Search,
    cost: Callable[[P, Array], float],
    bounds: Callable[[P], tuple[Array, Array]],
    problem: P,
    dimensions: dict[str, int],
    z_start: Array,
    *,
    tolerance: float,
) -> Solution:
    """Minimise ``cost(problem, z)`` within ``bounds(problem)`` by `search`; the residual is that of `active_set`."""
    n = z_start.shape[0]
    key = tuple(dimensions.items())
    data: Any = pack(problem)
    z, iterations = _callback(search, cost, bounds, type(problem), key, n)(z_start, data, tolerance)
    value, kkt = residual_function(cost, bounds, type(problem), key, n)(z, data)
    if is_symbolic(z):
        return Solution(z, value, kkt, iterations)
    return Solution(np.asarray(z, dtype=float).ravel(), float(value), float(kkt), float(iterations))
