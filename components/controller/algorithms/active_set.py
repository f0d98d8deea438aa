"""An active-set Newton method for a smooth cost with bounds, written as symbols so that it becomes plain C.

Each iteration, at z with gradient g and Hessian H:

1. a variable is active when it sits on a bound and g pushes it outwards;
2. p solves (H + lambda I) p = -g over the free variables, by an LDL' factorisation whose pivots are made positive,
   so that p is a direction of descent;
3. the best of several step lengths along the projection of z + alpha p on the bounds is taken, or z is kept;
4. lambda falls after a full step and grows when no step length helped (Levenberg-Marquardt).

The number of iterations is fixed: no branch depends on the numbers, so that each solve takes the same time and the
caller supplies all memory. The residual of the optimality conditions is |z - P(z - g)|, P the projection on the bounds.

References: D. P. Bertsekas, SIAM J. Control and Optimization 20 (1982); J. Nocedal, S. Wright, Numerical
Optimization (2006), 3.4 and 16.7.
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from components.interfaces.maths import Array, is_symbolic
from components.interfaces.record import pack
from components.interfaces.staging import symbols

P = TypeVar("P")

STEP_LENGTHS = (1.0, 0.5, 0.2, 0.05, 0.01)
SMALLEST_PIVOT = 1e-9
DAMPING_ON_FAILURE = 1e-3


@dataclass(frozen=True)
class Solution:
    """What a solve found."""

    z: Array
    cost: float
    kkt: float
    iterations: float
    """Iterations whose residual was above the tolerance."""


def minimise(  # noqa: PLR0913 - the parts of a bound-constrained problem
    cost: Callable[[P, Array], float],
    bounds: Callable[[P], tuple[Array, Array]],
    problem: P,
    dimensions: dict[str, int],
    z_start: Array,
    *,
    iterations: int,
    tolerance: float,
) -> Solution:
    """Minimise ``cost(problem, z)`` within ``bounds(problem)``, from `z_start`; numbers or graph symbols."""
    n = z_start.shape[0]
    iterate, residual = _functions(cost, bounds, type(problem), tuple(dimensions.items()), n)
    data = pack(problem)
    z: Any = z_start
    damping: Any = 0.0
    count: Any = 0.0
    for _ in range(iterations):
        z, damping, count = iterate(z, damping, count, data, tolerance)
    value: Any
    kkt: Any
    value, kkt = residual(z, data)
    if is_symbolic(z):
        return Solution(z, value, kkt, count)
    return Solution(np.asarray(z, dtype=float).ravel(), float(value), float(kkt), float(count))


@cache
def _functions(cost: Any, bounds: Any, kind: type, dimensions: Any, n: int) -> tuple[ca.Function, ca.Function]:
    data, problem = symbols(kind, dict(dimensions), name="data")
    z = ca.SX.sym("z", n)
    lower, upper = bounds(problem)
    J = cost(problem, z)
    H, g = ca.hessian(J, z)
    value = ca.Function("cost", [z, data], [J])
    kkt = _residual(z, g, lower, upper)

    damping, count, tolerance = ca.SX.sym("damping"), ca.SX.sym("count"), ca.SX.sym("tolerance")
    p = _direction(z, g, H, lower, upper, damping)
    best_z, best, taken = z, J, ca.SX(0)
    for alpha in reversed(STEP_LENGTHS):
        trial = _project(z + alpha * p, lower, upper)
        found = value(trial, data)
        better = found < best
        best_z, best = ca.if_else(better, trial, best_z), ca.if_else(better, found, best)
        taken = ca.if_else(better, alpha, taken)
    grown = ca.fmax(10 * damping, DAMPING_ON_FAILURE)
    next_damping = ca.if_else(taken <= 0, grown, ca.if_else(taken >= 1, damping / 10, damping))
    step = ca.Function(
        "iterate", [z, damping, count, data, tolerance], [best_z, next_damping, count + (kkt > tolerance)]
    )
    return step, residual_function(cost, bounds, kind, dimensions, n)


@cache
def residual_function(cost: Any, bounds: Any, kind: type, dimensions: Any, n: int) -> ca.Function:
    """``residual(z, data) -> (cost, kkt)``, for solutions from wherever."""
    data, problem = symbols(kind, dict(dimensions), name="data")
    z = ca.SX.sym("z", n)
    J = cost(problem, z)
    return ca.Function("residual", [z, data], [J, _residual(z, ca.gradient(J, z), *bounds(problem))])


def _residual(z: Any, g: Any, lower: Any, upper: Any) -> Any:
    return ca.mmax(ca.fabs(z - _project(z - g, lower, upper)))


def _project(z: Any, lower: Any, upper: Any) -> Any:
    return ca.fmin(ca.fmax(z, lower), upper)


def _direction(  # noqa: PLR0913 - the parts of one Newton step
    z: Any, g: Any, H: Any, lower: Any, upper: Any, damping: Any
) -> Any:
    """Solve for p by LDL' with positive pivots; active variables get p = 0."""
    n = z.numel()
    active = ca.logic_or(ca.logic_and(z <= lower, g > 0), ca.logic_and(z >= upper, g < 0))
    free = 1 - active
    A = H * (free @ free.T) + ca.diag(active + damping * free)
    L, d = ca.SX.eye(n), [ca.SX(0)] * n
    for j in range(n):
        pivot = A[j, j] - sum((L[j, k] * L[j, k] * d[k] for k in range(j)), ca.SX(0))
        d[j] = ca.fmax(ca.fabs(pivot), SMALLEST_PIVOT)
        for i in range(j + 1, n):
            L[i, j] = (A[i, j] - sum((L[i, k] * L[j, k] * d[k] for k in range(j)), ca.SX(0))) / d[j]
    p = -g * free
    for j in range(n):
        for k in range(j):
            p[j] -= L[j, k] * p[k]
    for j in range(n):
        p[j] /= d[j]
    for j in reversed(range(n)):
        for k in range(j + 1, n):
            p[j] -= L[k, j] * p[k]
    return p
