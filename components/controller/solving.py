"""One solve per sample: where it starts, and what is made of its end."""

from __future__ import annotations

from components.controller.algorithms.active_set import Solution
from components.interfaces.buses import Solver, SolverStatus
from components.interfaces.maths import Array, absolute, both, clip, joined, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record

N_P = 3
"""Prediction horizon of the paper, in prediction steps."""

ITERATIONS = 10
TOLERANCE = 1e-6
LARGEST = 1e9
"""Shown instead of a cost or residual that is not a number."""


@record
class Decision:
    """The decision that is applied, and how it was found."""

    solver: Solver
    z: Array = quantity("1", "scaled decision", shape=(2 * N_P,))


def shifted(z: Array) -> Array:
    """The previous plan one step further, its last decision kept."""
    return joined([z[1:N_P], z[N_P - 1 : N_P], z[N_P + 1 :], z[2 * N_P - 1 :]])


def accepted(bounds: tuple[Array, Array], found: Solution, guess: Array, tolerance: float = TOLERANCE) -> Decision:
    """The solution within its bounds, or the shifted previous plan where the solve gave no numbers."""
    finite = both(absolute(found.kkt) < LARGEST, absolute(found.cost) < LARGEST)  # false for a NaN
    lower, upper = bounds
    z = vector([clip(where(finite, found.z[i], guess[i]), lower[i], upper[i]) for i in range(2 * N_P)])
    ended = where(found.kkt <= tolerance, float(SolverStatus.converged), float(SolverStatus.iteration_limit))
    solver = Solver(
        status=where(finite, ended, float(SolverStatus.fallback)),
        iterations=found.iterations,  # type: ignore[arg-type] # a count among other columns of doubles
        cost=where(finite, found.cost, LARGEST),
        kkt=where(finite, found.kkt, LARGEST),
    )
    return Decision(z=z, solver=solver)
