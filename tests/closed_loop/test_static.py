"""The paper's static lane change as a whole: the same run three ways, and what a passenger would see."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components import SolverStatus
from fmus import Version
from orchestrator import Options, load, metrics, shown, simulate

WAYS = ["blocks", Version.FMI2, Version.FMI3]


def run(name, **options):
    made = load(name, Options(**options))
    return made, simulate(made.system, h=made.h, until=made.until)


@pytest.fixture(scope="module")
def static(built_fmus):
    return {way: run("static", mode=way)[1] for way in WAYS}


@pytest.mark.parametrize("way", [Version.FMI2, Version.FMI3])
def test_blocks_and_fmus_of_both_versions_agree_in_every_signal_over_all_ticks(static, way):
    reference, found = static["blocks"], static[way]
    assert list(found.columns) == list(reference.columns)
    assert len(found) == 114
    np.testing.assert_allclose(found.to_numpy(float), reference.to_numpy(float), rtol=0, atol=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_two_runs_are_identical(static, way):
    pd.testing.assert_frame_equal(run("static", mode=way)[1], static[way], check_exact=True)


def test_blocks_and_fmus_can_be_mixed_freely(static, built_fmus):
    mixed = {
        "plant": str(built_fmus / "fmi2" / "bicycle.fmu"),
        "controller": str(built_fmus / "fmi3" / "mpc.fmu"),
    }
    made, frame = run("static", mode="blocks", replacements=mixed)
    assert made.remarks == ()
    np.testing.assert_allclose(frame.to_numpy(float), static["blocks"].to_numpy(float), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["static", "static-literal"])
def test_the_run_ends_without_touching_an_obstacle_or_an_edge(name):
    made, frame = run(name, mode="blocks")
    found = metrics.compute(frame, shown(made.system), made.scene)
    judged = metrics.verdicts(found)
    assert judged["no_contact"]
    assert judged["inside_road"]
    assert judged["solver_converged"]
    assert frame["plant.state.x"].iloc[-1] > 110.5  # beside or beyond the last obstacle


def test_the_controller_answers_to_the_state_of_the_same_instant(static):
    """No hidden delay: the plan starts at the position in the same row."""
    frame = static["blocks"]
    ahead = frame["controller.plan.x[1]"] - frame["plant.state.x"]
    assert ahead.between(2.3, 2.6).all()  # 0.25 s at about 10 m/s


def test_static_change_begins_and_ends_where_the_resolutions_say(static):
    first = static["blocks"].iloc[0]
    assert first["controller.path.x[2]"] == pytest.approx(20.0, abs=1e-6)  # P1
    assert first["controller.path.x[8]"] == pytest.approx(37.005, abs=1e-3)  # P7
    assert first["controller.path.x[9]"] == pytest.approx(62.005, abs=1e-3)  # P8, after 25 m in the adjacent lane
    assert first["controller.path.y[8]"] == pytest.approx(3.5, abs=1e-9)


MIRRORED = [
    "controller.y_adjacent=-3.5",
    "controller.y_left=1.75",
    "controller.y_right=-5.25",
    "scene.y_adjacent=-3.5",
    "scene.y_left=1.75",
    "scene.y_right=-5.25",
    "traffic.y_start=[0.0, -3.5, -3.5]",
]


def odd(column):
    """Signals that change sign when left and right are exchanged."""
    signal = column.rpartition(".")[2].partition("[")[0]
    return signal in {"psi", "v_y", "r", "delta_f", "a_y", "r_dot"} or signal.startswith(("y", "alpha", "F_c"))


def test_the_mirrored_scenario_gives_the_mirrored_run(static):
    _, mirrored = run("static", mode="blocks", settings=MIRRORED)
    swapped = {
        f"controller.plan.y_{a}[{i}]": f"controller.plan.y_{b}[{i}]"
        for a, b in (("upper", "lower"), ("lower", "upper"))
        for i in (1, 2, 3)
    }
    expected = static["blocks"].rename(columns=swapped)[list(mirrored.columns)]
    for column in mirrored.columns.difference(["controller.solver.kkt", "controller.solver.iterations"]):
        flip = -1.0 if odd(column) else 1.0
        size = max(1.0, expected[column].abs().max())
        np.testing.assert_allclose(mirrored[column], flip * expected[column], rtol=0, atol=1e-7 * size, err_msg=column)


@pytest.mark.parametrize(
    ("settings", "status"),
    [
        (["controller.dt=1.0"], SolverStatus.iteration_limit),
        (["controller.b_1=1e308"], SolverStatus.fallback),  # a cost that is no number
    ],
    ids=["iteration_limit", "fallback"],
)
def test_a_solve_that_fails_shows_in_the_status_and_the_run_goes_on(settings, status):
    made = load("static", Options(mode="blocks", settings=settings))
    frame = simulate(made.system, h=made.h, until=0.5)
    assert frame["controller.solver.status"].tolist() == [status] * 6
    assert np.isfinite(frame.to_numpy(float)).all()
    assert frame["controller.actuation.T_r"].between(-160, 200).all()
