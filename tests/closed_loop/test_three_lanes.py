"""A road with three lanes as a whole: every controller that plans uses the third where the other two are taken."""

from __future__ import annotations

import numpy as np
import pytest

from components import BLOCKS
from fmus import Version
from orchestrator import Options, load, metrics, shown, simulate
from orchestrator.results.task import is_done, task
from tests.closed_loop.search import CONTROLLERS


def run(controller="mpc", mode="blocks", settings=()):
    made = load("three-lanes", Options(mode=mode, settings=settings, replacements={"controller": controller}))
    return made, simulate(made.system, h=made.h, until=made.until)


@pytest.fixture(scope="module")
def middle():
    return run()


def judged(made, frame):
    found = metrics.compute(frame, shown(made.system), made.scene)
    return metrics.verdicts(found) | is_done(task(frame, shown(made.system), made.scene, 10.0))


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_every_controller_takes_the_third_lane_and_touches_nobody(controller):
    made, frame = run(controller)
    assert frame["controller.path.y[8]"].min() == frame["controller.path.y[8]"].max() == -3.5
    assert frame["plant.state.y"].min() < -3.0
    verdicts = judged(made, frame)
    assert verdicts["no_contact"]
    assert verdicts["task_done"]
    two = load("static", Options(mode="blocks", replacements={"controller": controller}))
    static = judged(two, simulate(two.system, h=two.h, until=two.until))
    assert verdicts["inside_road"] == static["inside_road"]  # some baselines leave a road of two lanes, too


def test_where_the_adjacent_lane_is_free_it_is_taken():
    _, frame = run(settings=["traffic.valid=[true, false, true, true]"])
    assert frame["controller.path.y[8]"].max() == frame["controller.path.y[8]"].min() == 3.5


def test_the_run_is_that_of_two_lanes_mirrored(middle):
    """The lane on the right is as wide as that on the left, and the corridor around the path likewise."""
    _, frame = middle
    made = load("static", Options(mode="blocks"))
    two = simulate(made.system, h=made.h, until=made.until)
    np.testing.assert_allclose(frame["plant.state.y"], -two["plant.state.y"], rtol=0, atol=0.05)


BEYOND = [
    "controller.y_third=7.0",
    "scene.y_third=7.0",
    "scene.y_left=8.75",
    "scene.y_right=-1.75",
    "traffic.x_start=[69.5, 69.5, 130.5, 140.5]",
    "traffic.y_start=[0.0, 3.5, 3.5, 7.0]",
]


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_third_lane_beyond_the_adjacent_one_is_taken(controller):
    edges = ["controller.y_left=8.75", "controller.y_right=-1.75"]
    known = {p.name for p in BLOCKS[controller].parameters()}
    made, frame = run(controller, settings=[*BEYOND, *(edges if "y_left" in known else [])])
    assert frame["controller.path.y[8]"].max() == 7.0
    assert frame["plant.state.y"].max() > 6.0
    assert judged(made, frame)["no_contact"]


@pytest.mark.parametrize("way", [Version.FMI2, Version.FMI3])
def test_fmus_give_the_numbers_of_blocks(built_fmus, middle, way):
    _, reference = middle
    _, found = run(mode=way)
    np.testing.assert_allclose(found.to_numpy(float), reference.to_numpy(float), rtol=0, atol=1e-9)
