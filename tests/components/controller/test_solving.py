"""Where a solve starts, and what is made of its end."""

from __future__ import annotations

import numpy as np
import pytest

from components.controller.algorithms.bounded import Solution
from components.controller.problems.ocp import Horizon
from components.controller.solving import LARGEST_SHOWN, accepted, decided, shifted, shown_plan
from components.interfaces.buses import SolverStatus, VehicleState
from components.interfaces.record import pack

GUESS = np.array([0.1, 0.2, 0.3, -0.4, 0.5, 0.6])


def ended(**changes) -> Solution:
    return Solution(**{"z": np.full(6, 0.7), "cost": 2.0, "kkt": 1e-7, "iterations": 4.0, **changes})


def test_the_plan_moves_on_by_one_step_and_keeps_its_last_inputs():
    assert shifted(GUESS).tolist() == [0.2, 0.3, 0.3, 0.5, 0.6, 0.6]


@pytest.mark.parametrize(("kkt", "status"), [(1e-7, SolverStatus.converged), (1e-5, SolverStatus.iteration_limit)])
def test_a_solve_that_gave_numbers_is_applied(kkt, status):
    z, solver = accepted(ended(kkt=kkt), GUESS, 1e-6)
    assert z.tolist() == [0.7] * 6
    assert (solver.status, solver.iterations, solver.cost, solver.kkt) == (status, 4.0, 2.0, kkt)


@pytest.mark.parametrize("lost", [{"cost": np.nan}, {"kkt": np.nan}, {"cost": np.inf}, {"kkt": 2e9}])
def test_a_solve_that_gave_none_leaves_the_guess(lost):
    z, solver = accepted(ended(**lost), GUESS, 1e-6)
    assert z.tolist() == GUESS.tolist()
    assert (solver.status, solver.cost, solver.kkt) == (SolverStatus.fallback, LARGEST_SHOWN, LARGEST_SHOWN)


def test_a_decision_stays_within_its_bounds():
    bounds = np.full(6, -0.2), np.array([0.1, 0.2, 0.3, 1.0, 1.0, 1.0])
    assert decided(ended(), GUESS, bounds).z.tolist() == [0.1, 0.2, 0.3, 0.7, 0.7, 0.7]
    assert decided(ended(cost=np.nan), GUESS, bounds).z.tolist() == [0.1, 0.2, 0.3, -0.2, 0.5, 0.6]


@pytest.mark.parametrize("lost", [False, True])
def test_after_a_fallback_the_plan_shows_the_path(lost):
    two = [np.array([1.0, 2.0]) * factor for factor in (1, 2, 3, 4)]
    horizon = Horizon(**dict(zip(("x_d", "y_d", "y_upper", "y_lower"), two, strict=True)))
    states = [VehicleState(x=x, y=-x, psi=0.0, v_x=1.0, v_y=0.0, r=0.0) for x in (7.0, 8.0)]
    _, solver = accepted(ended(cost=np.nan) if lost else ended(), GUESS, 1e-6)
    plan = shown_plan(horizon, states, solver)
    assert plan.x.tolist() == (horizon.x_d.tolist() if lost else [7.0, 8.0])
    assert plan.y.tolist() == (horizon.y_d.tolist() if lost else [-7.0, -8.0])
    assert pack(plan)[4:].tolist() == pack(horizon).tolist()
