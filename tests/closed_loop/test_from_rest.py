"""Every controller starts every plant of ours from rest, passes the obstacle and comes up to speed."""

from __future__ import annotations

import pytest

from orchestrator import Options, load, metrics, shown, simulate

CONTROLLERS = ["mpc", "mpc_plus", "lqr", "stanley", "pure_pursuit", "two_level_mp"]


@pytest.mark.parametrize("plant", ["bicycle", "bicycle_saturated"])
@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("v_x", [0.0, 2.0])
def test_from_rest_the_task_is_done(plant, controller, v_x):
    replaced = {"controller": controller, "plant": plant}
    made = load("static", Options(mode="blocks", settings=[f"plant.v_x_start={v_x}"], replacements=replaced))
    frame = simulate(made.system, h=made.h, until=20.0)
    found = metrics.compute(frame, shown(made.system), made.scene)
    assert metrics.verdicts(found)["no_contact"]
    assert found["path_error_max"] < 1.2
    assert found["mu_f_max"] < 4
    assert frame["plant.state.v_x"].iloc[-1] == pytest.approx(10, abs=1)
    assert frame["plant.state.x"].iloc[-1] > 90  # behind the obstacle and the way back
