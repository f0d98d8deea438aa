"""mpc_plus against what it was made for."""

from __future__ import annotations

import numpy as np
import pytest

from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator import Options, load, metrics, shown, simulate


def run(scenario, controller, plant, **options):
    replacements = {"controller": controller, "plant": plant}
    made = load(scenario, Options(replacements=replacements, **options))
    frame = simulate(made.system, h=made.h, until=made.until)
    return frame, metrics.compute(frame, shown(made.system), made.scene)


@pytest.mark.parametrize("plant", ["bicycle", "bicycle_saturated"])
def test_it_is_smoother_than_the_tuned_controller_and_within_a_quarter_of_a_metre(plant):
    rows, plus = run("static", "mpc_plus", plant, mode="blocks")
    others, tuned = run("static", "mpc", plant, mode="blocks")
    for i in range(1, 13):  # P0..P11 of the same path
        for axis in "xy":
            name = f"controller.path.{axis}[{i}]"
            assert rows[name].iloc[0] == pytest.approx(others[name].iloc[0], abs=1e-9)
    assert plus["r_dot_rms"] < tuned["r_dot_rms"]
    assert plus["path_error_rms"] <= 0.25
    judged = metrics.verdicts(plus)
    assert judged["no_contact"]
    assert judged["inside_road"]
    assert judged["within_friction_limit"]


@pytest.mark.parametrize("scenario", ["dynamic", "dynamic-slow"])
def test_moving_traffic_is_avoided(scenario):
    _, plus = run(scenario, "mpc_plus", "bicycle_saturated", mode="blocks")
    assert metrics.verdicts(plus)["no_contact"]
    assert metrics.verdicts(plus)["inside_road"]


def test_the_friction_limit_is_respected_on_a_slippery_road():
    settings = ["plant.mu=0.4", "controller.mu=0.4"]
    _, plus = run("static", "mpc_plus", "bicycle", mode="blocks", settings=settings)
    assert plus["mu_f_max"] <= 1
    assert plus["mu_r_max"] <= 1


def test_as_an_fmu_it_drives_the_same(built_fmus):
    block, _ = run("static", "mpc_plus", "bicycle_saturated", mode="blocks")
    for version in WRITTEN_VERSIONS:
        fmu, _ = run("static", "mpc_plus", "bicycle_saturated", mode=version)
        np.testing.assert_allclose(fmu.to_numpy(float), block.to_numpy(float), rtol=0, atol=1e-9)


def test_behind_an_obstacle_that_cannot_be_passed_it_brakes_and_keeps_its_lane():
    settings = ["traffic.x_start=[110.0, 105.0, 150.0]"]  # both lanes taken
    frame, plus = run("static", "mpc_plus", "bicycle_saturated", mode="blocks", settings=settings)
    assert frame["plant.state.v_x"].iloc[-1] < 8
    assert frame["plant.state.y"].abs().max() < 0.3
    assert metrics.verdicts(plus)["no_contact"]
