"""An active-set Newton method for a smooth cost with bounds, written as symbols so that it becomes plain C.

Each iteration, at z with gradient g and Hessian H:

1. a variable is active when it sits on a bound and g pushes it outwards;
2. p solves (H + lambda I) p = -g over the free variables, by an LDL' factorisation whose pivots are made positive,
   so that p is a direction of descent;
3. the best of several step lengths along the projection of z + alpha p on the bounds is taken, or z is kept;
4. lambda falls after a full step and grows when no step length helped (Levenberg-Marquardt).

The search ends with the first iteration that finds z converged. It still makes its step, by which a residual of 1e-6
becomes one of 1e-10, and it makes it in full, undamped: so close to the optimum, the costs of the step lengths differ
by rounding only, and choosing by them stops short of the minimiser. The residual of the optimality conditions is that
of `bounded`.

References: D. P. Bertsekas, SIAM J. Control and Optimization 20 (1982); J. Nocedal, S. Wright, Numerical
Optimization (2006), 3.4 and 16.7.
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca

from components.controller.algorithms.bounded import (
    BoundedProblem,
    Dimensions,
    Solution,
    SymbolicProblem,
    projected,
    residual,
    solution,
    symbolic,
)
from components.controller.algorithms.repetition import repeated
from components.interfaces.maths import Array
from components.interfaces.record import pack

_STEP_LENGTHS = (1.0, 0.5, 0.2, 0.05, 0.01)
_SMALLEST_PIVOT = 1e-9
_DAMPING_ON_FAILURE = 1e-3
_ROUNDING = 1e-9
"""The share of the cost by which trials may differ without meaning, once z has converged."""
_NO_STEP = 1e-12
"""The largest element of a step that is rounding itself."""


def minimise(
    problem: BoundedProblem, dimensions: dict[str, int], z_start: Array, *, iterations: int, tolerance: float
) -> Solution:
    """Minimise ``problem.cost(z)`` within ``problem.bounds()``.

    Args:
        problem: A record of numbers or of graph symbols.
        dimensions: The structural constants that give the lengths of its arrays.
        z_start: Where the search begins, of shape (n,).
        iterations: How many are made at most.
        tolerance: Residual of the optimality conditions up to which z has converged; above it, an iteration counts as
            needed.

    Returns:
        The solution, in numbers or graph symbols as the problem is.
    """
    kind, key = type(problem), tuple(dimensions.items())
    search = _search(kind, key, z_start.shape[0], iterations)
    data = pack(problem)
    z, _, count = search(z_start, 0.0, 0.0, data, tolerance)
    return solution(kind, key, data, z, count)


@cache
def _search(kind: type, dimensions: Dimensions, n: int, iterations: int) -> ca.Function:
    """``search(z, damping, count, data, tolerance) -> (z, damping, count)``."""
    return repeated(_iteration(kind, dimensions, n), iterations)


def _iteration(kind: type, dimensions: Dimensions, n: int) -> ca.Function:
    """``iterate(z, damping, count, data, tolerance) -> (z, damping, count, converged)``."""
    problem = symbolic(kind, dimensions, n)
    z, data, J = problem.z, problem.data, problem.cost
    H, g = ca.hessian(J, z)
    value = ca.Function("cost", [z, data], [J])
    kkt = residual(problem, g)

    damping, count, tolerance = ca.SX.sym("damping"), ca.SX.sym("count"), ca.SX.sym("tolerance")
    converged = kkt <= tolerance
    p = _direction(problem, g, H, ca.if_else(converged, 0, damping))
    slack = ca.if_else(ca.logic_and(converged, ca.norm_inf(p) > _NO_STEP), _ROUNDING * ca.fabs(J), 0)
    best_z, best, taken = z, J, ca.SX(0)
    for alpha in reversed(_STEP_LENGTHS):
        trial = projected(problem, z + alpha * p)
        trial_cost = value(trial, data)
        better = trial_cost < best + slack  # the longest comes last
        best_z, best = ca.if_else(better, trial, best_z), ca.if_else(better, trial_cost, best)
        taken = ca.if_else(better, alpha, taken)
    grown = ca.fmax(10 * damping, _DAMPING_ON_FAILURE)
    next_damping = ca.if_else(taken <= 0, grown, ca.if_else(taken >= 1, damping / 10, damping))
    results: Any = ca.cse([best_z, next_damping, count + (kkt > tolerance), converged])
    return ca.Function("iterate", [z, damping, count, data, tolerance], results)


def _direction(problem: SymbolicProblem, g: Any, H: Any, damping: Any) -> Any:
    """Solve for p by LDL' with positive pivots; active variables get p = 0."""
    z, lower, upper = problem.z, problem.lower, problem.upper
    n = z.numel()
    active = ca.logic_or(ca.logic_and(z <= lower, g > 0), ca.logic_and(z >= upper, g < 0))
    free = 1 - active
    A = H * (free @ free.T) + ca.diag(active + damping * free)
    L, d = ca.SX.eye(n), [ca.SX(0)] * n
    for j in range(n):
        pivot = A[j, j] - sum((L[j, k] * L[j, k] * d[k] for k in range(j)), ca.SX(0))
        d[j] = ca.fmax(ca.fabs(pivot), _SMALLEST_PIVOT)
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
