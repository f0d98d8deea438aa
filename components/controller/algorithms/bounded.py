"""Problems whose only constraints are bounds: the interface for algorithms, and the form of a solution.

The residual of the optimality (KKT) conditions is the largest element of |z - P(z - g)|, with the gradient g of the
cost and the projection P on the bounds. It is evaluated here for every algorithm, so that their solutions compare.
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol, TypeAlias

import casadi as ca
import numpy as np

from components.interfaces.maths import Array, is_symbolic
from components.interfaces.staging import symbols

Dimensions: TypeAlias = tuple[tuple[str, int], ...]
"""Structural constants and their values, in a form that can be the key of a cache."""


class BoundedProblem(Protocol):
    """A record of data with a smooth cost of a decision z, of shape (n,), and bounds on z."""

    def cost(self, z: Array) -> float:
        """The cost of the decision z."""
        ...

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of z, each of shape (n,)."""
        ...


@dataclass(frozen=True)
class Solution:
    """The result of a search, by whichever algorithm."""

    z: Array
    """Decision, of shape (n,)."""
    cost: float
    kkt: float
    """Measure of how far the decision is from optimal."""
    iterations: float
    """Iterations that the search needed."""


@dataclass(frozen=True)
class SymbolicProblem:
    """The expressions of a problem in the column `data` of its values and the decision `z`."""

    data: Any
    z: Any
    cost: Any
    lower: Any
    upper: Any


@cache
def symbolic(kind: type, dimensions: Dimensions, n: int) -> SymbolicProblem:
    """The problems of type `kind` with a decision of shape (n,)."""
    data, problem = symbols(kind, dict(dimensions), name="data")
    z = ca.SX.sym("z", n)
    lower, upper = problem.bounds()
    return SymbolicProblem(data, z, problem.cost(z), lower, upper)


def solution(kind: type, dimensions: Dimensions, data: Any, z: Any, iterations: Any) -> Solution:
    """`z` as the solution of the problem of type `kind` whose values are `data`; numbers or graph symbols."""
    cost, kkt = _residual_function(kind, dimensions, z.shape[0])(z, data)
    if is_symbolic(z):
        return Solution(z, cost, kkt, iterations)
    return Solution(np.asarray(z, dtype=float).ravel(), float(cost), float(kkt), float(iterations))


@cache
def _residual_function(kind: type, dimensions: Dimensions, n: int) -> ca.Function:
    """``residual(z, data) -> (cost, kkt)``."""
    problem = symbolic(kind, dimensions, n)
    kkt = residual(problem, ca.gradient(problem.cost, problem.z))
    results: Any = ca.cse([problem.cost, kkt])
    return ca.Function("residual", [problem.z, problem.data], results)


def residual(problem: SymbolicProblem, gradient: Any) -> Any:
    """The residual of the optimality conditions where the cost has this gradient, of shape (n,)."""
    return ca.mmax(ca.fabs(problem.z - projected(problem, problem.z - gradient)))


def projected(problem: SymbolicProblem, z: Any) -> Any:
    """The point within the bounds that is nearest to `z`."""
    return ca.fmin(ca.fmax(z, problem.lower), problem.upper)
