"""The same run under the three master algorithms."""

from __future__ import annotations

import numpy as np
import pytest

from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator import Options, load, metrics, shown, simulate


@pytest.fixture(scope="module")
def runs(built_fmus):
    """Rows of `static` by algorithm and by what the blocks run as."""
    found = {}
    for mode in ("blocks", *WRITTEN_VERSIONS):
        made = load("static", Options(mode=mode))
        for algorithm in ("jacobi", "clocked", *(["sequential"] if mode == "blocks" else [])):
            found[algorithm, mode] = simulate(made.system, h=made.h, until=made.until, algorithm=algorithm)
    return made, found


@pytest.mark.parametrize("mode", ["blocks", *WRITTEN_VERSIONS])
def test_clocked_gives_the_numbers_of_sequential(runs, mode):
    """With FMI 3.0 the controller is activated by its clock in Event Mode; elsewhere it acts early."""
    _, found = runs
    reference = found["sequential", "blocks"].to_numpy(float)
    np.testing.assert_allclose(found["clocked", mode].to_numpy(float), reference, rtol=0, atol=1e-9)


@pytest.mark.parametrize("mode", WRITTEN_VERSIONS)
def test_jacobi_gives_the_same_numbers_for_blocks_and_fmus(runs, mode):
    _, found = runs
    reference = found["jacobi", "blocks"].to_numpy(float)
    np.testing.assert_allclose(found["jacobi", mode].to_numpy(float), reference, rtol=0, atol=1e-9)


def test_jacobi_hands_the_actuation_over_one_step_late(runs):
    """The first sample is shown twice: at the start, and after the first step; from then on the runs part."""
    _, found = runs
    late, direct = (found[a, "blocks"]["controller.actuation.delta_f"].to_numpy() for a in ("jacobi", "sequential"))
    assert late[0] == late[1] == direct[0]
    assert late[2] == direct[1]
    assert late[3] != direct[2]


def test_one_step_of_delay_costs_friction_and_room(runs):
    made, found = runs
    buses = shown(made.system)
    direct, late = (metrics.compute(found[a, "blocks"], buses, made.scene) for a in ("sequential", "jacobi"))
    assert metrics.verdicts(late)["no_contact"]
    assert late["mu_f_max"] > direct["mu_f_max"]
    assert late["gap_edge"] < direct["gap_edge"]
