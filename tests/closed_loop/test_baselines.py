"""The two-level baselines on the static scenario, in the range of an independent prototype of the paper's system."""

from __future__ import annotations

import numpy as np
import pytest

from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator import Options, load, metrics, shown, simulate

NAMES = ["static-lqr", "static-stanley", "static-pure-pursuit", "static-two-level-mp"]


def run(name, *settings, mode="blocks", **replacements):
    made = load(name, Options(mode=mode, settings=settings, replacements=replacements))
    frame = simulate(made.system, h=made.h, until=made.until)
    return frame, metrics.compute(frame, shown(made.system), made.scene)


# name, settings, and of the prototype: path error rms and largest [m], total variation of r [rad/s], rms r_dot [rad/s2]
PROTOTYPE = [
    ("static-stanley", [], (0.416, 0.934, 7.9, 1.10)),
    ("static-pure-pursuit", [], (0.397, 0.903, 1.7, 0.20)),
]


@pytest.mark.parametrize(("name", "settings", "expected"), PROTOTYPE)
def test_a_baseline_does_what_the_prototype_did(name, settings, expected):
    _, found = run(name, *settings)
    metrics = ("path_error_rms", "path_error_max", "r_total_variation", "r_dot_rms")
    assert [found[m] for m in metrics] == pytest.approx(expected, rel=0.1)
    assert found["gap_obstacle"] > 1


def test_lqr_trades_accuracy_for_smoothness_in_the_range_of_the_prototype():
    plain = ["controller.q_e_dot=0.0", "controller.q_psi=1.0"]
    found = [run("static-lqr", *plain, f"controller.q_delta={q}")[1] for q in (1.0, 10.0, 30.0)]
    errors = [f["path_error_rms"] for f in found]
    variations = [f["r_total_variation"] for f in found]
    assert errors == sorted(errors)
    assert variations == sorted(variations, reverse=True)
    assert 0.042 < errors[0] < errors[-1] < 0.255
    assert 10.4 < variations[-1] < variations[0] < 17.6
    assert all(f["gap_obstacle"] > 1 for f in found)


def test_the_point_mass_plan_is_tracked_without_contact_and_every_solve_converges():
    frame, found = run("static-two-level-mp")
    assert found["gap_obstacle"] > 1
    assert found["path_error_rms"] < 0.2
    assert found["solver_fallbacks"] == found["solver_limits"] == 0
    assert frame["controller.plan.x[1]"].sub(frame["plant.state.x"]).between(2.0, 3.0).all()


@pytest.mark.parametrize("dt", [0.1, 0.45, 0.55])
def test_the_solves_converge_at_prediction_steps_much_longer_than_a_sample(dt):
    _, found = run("static-two-level-mp", f"controller.dt={dt}", "controller.q_delta=1.0")
    assert found["solver_fallbacks"] == found["solver_limits"] == 0
    assert found["delta_f_rate_rms"] < (0.3 if dt > 0.4 else 2.0)  # one bad solve shows as a jerk


@pytest.mark.parametrize("name", ["static-lqr", "static-pure-pursuit"])
def test_in_their_own_setting_they_stay_on_the_road(name):
    _, found = run(name)
    assert found["gap_edge"] > 0
    assert found["gap_obstacle"] > 1
    assert 9.0 < found["v_x_min"] < found["v_x_max"] < 10.1


@pytest.mark.parametrize("name", NAMES)
def test_their_path_is_that_of_mpc_at_every_tick(name):
    frame, mpc = run(name)[0], run("static")[0]
    columns = [f"controller.path.{axis}[{i}]" for axis in "xy" for i in range(1, 13)]
    assert np.abs(frame[columns].to_numpy() - mpc[columns].to_numpy()).max() < 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_blocks_and_fmus_give_the_same_run(name, built_fmus):
    blocks = run(name)[0]
    for version in WRITTEN_VERSIONS:
        found = run(name, mode=version)[0]
        np.testing.assert_allclose(found.to_numpy(float), blocks.to_numpy(float), rtol=0, atol=1e-9)
