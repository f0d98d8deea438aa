"""The varied set: each case can be run again by its command."""

from __future__ import annotations

import shlex
from itertools import pairwise

import numpy as np
import pytest

from orchestrator.reproduction import runs
from orchestrator.reproduction.varied import variations, varied_set
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate

PLAN = variations.load()
CASES = [variations.draw(PLAN.ranges, 3, number) for number in range(6)]


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_case_run_again_by_its_command_gives_the_same_rows(number, built_fmus):
    case = CASES[number]
    controller = next(d for d in PLAN.controllers if d.name == ("lqr-light" if number == 0 else "mpc-literal"))
    words = shlex.split(variations.command(case, controller, PLAN.plant))
    options = dict(pairwise(words))
    made = prepare(
        words[2],
        Options(
            mode=runs.MODE,
            replacements={"plant": options["--plant"], "controller": options["--controller"]},
            settings=[value for name, value in pairwise(words) if name == "--set"],
            stop_time=float(options["--stop-time"]),
        ),
    )
    again = simulate(made.system, h=made.h, until=made.until)
    varied_set.simulate(CASES[number + 3], controller, PLAN.plant)  # so that the FMUs have been used before
    frame, scene, fault = varied_set.simulate(case, controller, PLAN.plant)
    assert not fault
    assert scene == made.scene or vars(scene) == vars(made.scene)
    np.testing.assert_array_equal(frame.to_numpy(float), again.to_numpy(float))
