"""Solves that stop when they have converged, against the same searches with all their iterations, in every scenario."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import orchestrator
from components import BLOCKS
from components.controller.algorithms import active_set, ilqr
from components.interfaces.record import pack, unpack
from fmus.lowering import lower
from fmus.units.block_unit import BlockUnit
from orchestrator import Options, load, simulate

SCENARIOS = sorted(path.stem for path in (Path(orchestrator.__file__).parent / "scenarios").glob("*.toml"))
CONTROLLERS = {"mpc": "z", "two_level_mp": "z", "mpc_plus": "u"}
"""The controllers whose solve becomes C, and the state that holds the minimiser."""


def unending(iterate: ca.Function, at_most: int) -> ca.Function:
    """In the place of `repeated`: as many iterations as there may be, converged or not."""
    arguments = iterate.mx_in()
    n = iterate.n_out() - 1
    values, data = arguments[:n], arguments[n:]
    for _ in range(at_most):
        *values, _ = iterate(*values, *data)
    return ca.Function("search", arguments, values)


@cache
def with_all_iterations(controller: str) -> ca.Function:
    """The step of a controller whose solves do not stop."""
    with pytest.MonkeyPatch.context() as patch:
        for algorithm, made in ((active_set, "_search"), (ilqr, "_functions")):
            patch.setattr(algorithm, "repeated", unending)
            patch.setattr(algorithm, made, getattr(algorithm, made).__wrapped__)
        return lower.__wrapped__(BLOCKS[controller]).step


def driven(monkeypatch, scenario, controller):
    """State, inputs and parameters of the controller at every tick of a run."""
    seen = []
    step = BlockUnit.step

    def noted(self, t, h):
        if self.name == "controller":
            seen.append(tuple(column.copy() for column in (self._memory.x, self._u, self._p)))
        return step(self, t, h)

    monkeypatch.setattr(BlockUnit, "step", noted)
    made = load(scenario, Options(mode="blocks", replacements={"controller": controller}))
    simulate(made.system, h=made.h, until=made.until)
    return seen


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_stopping_changes_no_minimiser(monkeypatch, scenario, controller):
    block = BLOCKS[controller]
    dims = block.dimensions()
    stopping, unending_step = lower(block).step, with_all_iterations(controller)
    for x, u, p in driven(monkeypatch, scenario, controller):
        (state, shown), (state_all, shown_all) = (
            [
                unpack(kind, np.asarray(column).ravel(), dims)
                for kind, column in zip((block.state_type, block.output_type), step(x, u, p, 0.1), strict=True)
            ]
            for step in (stopping, unending_step)
        )
        found, reference = (getattr(s, CONTROLLERS[controller]) for s in (state, state_all))
        np.testing.assert_allclose(found, reference, rtol=0, atol=1e-9)
        np.testing.assert_allclose(pack(state.manoeuvre), pack(state_all.manoeuvre), rtol=0, atol=0)
        assert shown.solver.status == shown_all.solver.status
        if controller != "mpc_plus":  # whose count is of the iterations that lowered the cost, be it by rounding
            assert shown.solver.iterations == shown_all.solver.iterations
