"""What the predictive controllers share: the start of a solve, the acceptance of its result, and the outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from components.controller.algorithms.bounded import Solution
from components.controller.problems.ocp import Horizon, by_input
from components.interfaces.buses import Actuation, Plan, Solver, SolverStatus, Waypoints
from components.interfaces.maths import Array, clip, is_number, joined, vector, where
from components.interfaces.quantity import quantity
from components.interfaces.record import record

N_P = 3
"""Prediction horizon of the paper, in prediction steps."""

KKT_TOLERANCE = 1e-6
LARGEST_SHOWN = 1e9
"""Shown instead of a cost or residual that is not a number."""


@record
class PredictiveOutputs:
    """All buses that a predictive controller shows."""

    actuation: Actuation
    path: Waypoints
    plan: Plan
    solver: Solver


@record
class Decision:
    """The decision that is applied, and how it was found."""

    solver: Solver
    z: Array = quantity("1", "scaled decision", shape=(2 * N_P,))


class _Position(Protocol):
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...


def shifted(z: Array) -> Array:
    """The previous plan, of shape (2 N_p,), one step further; the last decision on each input is kept."""
    return joined([part for half in by_input(z) for part in (half[1:], half[-1:])])


def accepted(found: Solution, guess: Array, tolerance: float) -> tuple[Array, Solver]:
    """The decision to apply, and how the solve ended.

    Args:
        found: The result of the solve.
        guess: The decision that is applied where the solve gave no numbers.
        tolerance: The residual up to which the solve has converged.
    """
    known = is_number(found.kkt, found.cost, limit=LARGEST_SHOWN)
    z = vector([where(known, found.z[i], guess[i]) for i in range(guess.shape[0])])
    ended = where(found.kkt <= tolerance, float(SolverStatus.converged), float(SolverStatus.iteration_limit))
    return z, Solver(
        status=where(known, ended, float(SolverStatus.fallback)),
        iterations=found.iterations,  # type: ignore[arg-type] # a count among other columns of doubles
        cost=where(known, found.cost, LARGEST_SHOWN),
        kkt=where(known, found.kkt, LARGEST_SHOWN),
    )


def decided(found: Solution, guess: Array, bounds: tuple[Array, Array], tolerance: float = KKT_TOLERANCE) -> Decision:
    """What `accepted` gives, within lower and upper bounds."""
    z, solver = accepted(found, guess, tolerance)
    lower, upper = bounds
    return Decision(z=vector([clip(z[i], lower[i], upper[i]) for i in range(2 * N_P)]), solver=solver)


def shown_plan(horizon: Horizon, predicted: Sequence[_Position], solver: Solver) -> Plan:
    """The predicted positions at k+1..k+N_p; those of the path after a fallback, when there may be no prediction."""
    lost = solver.status == float(SolverStatus.fallback)
    return horizon.plan(
        x=vector([where(lost, horizon.x_d[i], at.x) for i, at in enumerate(predicted)]),
        y=vector([where(lost, horizon.y_d[i], at.y) for i, at in enumerate(predicted)]),
    )
