"""More obstacles than the bus has slots, as a whole: three ways to run it, three algorithms, and there and back."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from fmus import Version
from orchestrator import Options, load, metrics, shown, simulate
from orchestrator.results.task import is_done, task

X = [-60.0 + 20 * i for i in range(20)]
LISTS = {
    "valid": [True] * 20,
    "x_start": X,
    "y_start": [3.5 if x < 100 else 0.0 for x in X],
    "v_start": [0.5 * i for i in range(20)],
    "v_final": [0.5 * i for i in range(20)],
}
SETTINGS = [f"traffic.{name}={value}".lower() for name, value in LISTS.items()]


@pytest.fixture(scope="module")
def dense():
    made = load("dense", Options(mode="blocks"))
    return made, simulate(made.system, h=made.h, until=made.until)


def test_the_nearest_are_shown_first_at_every_instant(dense):
    made, frame = dense
    given = made.system.units["traffic"].parameters
    for _, row in frame.iloc[::20].iterrows():
        d = np.hypot(*(np.array(given[f"{a}_start"][:20]) - row[f"plant.state.{a}"] for a in "xy"))
        assert [row[f"traffic.obstacles.id[{i}]"] for i in range(1, 9)] == (np.argsort(d)[:8] + 1).tolist()


def test_the_ego_passes_those_in_its_lane_without_touching_anybody(dense):
    made, frame = dense
    found = metrics.compute(frame, shown(made.system), made.scene)
    assert all(metrics.verdicts(found).values())
    known = task(frame, shown(made.system), made.scene, 10.0)
    assert known["obstacles_to_pass"] == known["obstacles_passed"] == 3
    assert is_done(known) == {"task_done": True}


@pytest.mark.parametrize("way", [Version.FMI2, Version.FMI3])
@pytest.mark.parametrize("algorithm", ["sequential", "clocked", "jacobi"])
def test_fmus_give_the_numbers_of_blocks(built_fmus, way, algorithm):
    blocks, fmus = (load("dense", Options(mode=mode)) for mode in ("blocks", way))
    found, reference = (simulate(m.system, h=m.h, until=8.0, algorithm=algorithm) for m in (fmus, blocks))
    np.testing.assert_allclose(found.to_numpy(float), reference.to_numpy(float), rtol=0, atol=1e-9)


def test_a_list_of_twenty_takes_another_block_than_the_scenarios():
    with pytest.raises(RequestError) as refused:
        load("static", Options(mode="blocks", settings=SETTINGS))
    assert [str(problem) for problem in refused.value.problems] == [
        f"traffic.{name}: found shape (20,); valid: shape (8,). The block `dense_traffic` holds 32 obstacles:"
        " `--traffic dense_traffic`, or `block` in the scenario."
        for name in LISTS
    ]
    made = load("static", Options(mode="blocks", settings=SETTINGS, replacements={"traffic": "dense_traffic"}))
    frame = simulate(made.system, h=made.h, until=5.0)
    for _, row in frame.iterrows():
        identity = np.array([row[f"traffic.obstacles.id[{i}]"] for i in range(1, 9)], dtype=int) - 1
        x = [row[f"traffic.obstacles.x[{i}]"] for i in range(1, 9)]
        assert x == pytest.approx(np.array(X)[identity] + 0.5 * identity * row["time"])


def test_the_scenarios_three_obstacles_are_those_of_the_other_block_too():
    made = load("static", Options(mode="blocks", replacements={"traffic": "dense_traffic"}))
    other = load("static", Options(mode="blocks"))
    found, reference = (simulate(m.system, h=m.h, until=m.until) for m in (made, other))
    np.testing.assert_allclose(found["plant.state.y"], reference["plant.state.y"], rtol=0, atol=1e-6)
