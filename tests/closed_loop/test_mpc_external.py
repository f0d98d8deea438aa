"""Three algorithms, one problem: they meet the same minimiser.

This shows `mpc_external.py`.
"""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator import Options, load, simulate


@pytest.fixture(scope="module")
def run():
    def frame(scenario, **options):
        made = load(scenario, Options(mode="blocks", **options))
        return simulate(made.system, h=made.h, until=made.until)

    return frame


@pytest.mark.parametrize("scenario", ["static-sqp", "static-interior-point"])
def test_sqp_and_interior_point_drive_as_the_active_set_does(run, scenario):
    reference, found = run("static"), run(scenario)
    for signal in ("x", "y", "psi", "r"):
        np.testing.assert_allclose(found[f"plant.state.{signal}"], reference[f"plant.state.{signal}"], atol=2e-3)
    assert (found["controller.solver.status"] == 1).all()


def test_left_unscaled_with_a_loose_tolerance_it_stops_early_and_the_speed_sags(run):
    scaled, unscaled = run("static-sqp"), run("static-unscaled")
    assert unscaled["controller.solver.kkt"].max() > 10 * scaled["controller.solver.kkt"].max()
    assert unscaled["plant.state.v_x"].min() < scaled["plant.state.v_x"].min() - 0.2
