"""The rules of the planners hold in scenarios by chance, for every controller; `search` tries any number of them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.closed_loop.search import CONTROLLERS, Case, drawn


@pytest.mark.parametrize("seed", range(4))
def test_scenarios_by_chance_break_no_rule(seed):
    random = np.random.default_rng(seed)
    for _ in range(12):
        case = drawn(random)
        assert case.breaches() == {}, case


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_both_lanes_taken_ahead_of_a_return(controller):
    """Once opened a finished return again for one sample; and the desired point jumped back, and took `mpc` along."""
    case = Case(controller, v_ref=20.0, v_start=20.0, x=(60, 130, 160), lanes=(0, 1, 0), v=(5, 5, 5))
    assert case.breaches() == {}


def test_breaches_are_found():
    case = Case("lqr", v_ref=10.0, v_start=10.0, x=(60,), lanes=(0,), v=(0,))
    frame = case.run()
    row = int(np.argmax(frame["plant.state.x"] > frame["controller.path.x[9]"] + 1))  # the return has begun
    moved = frame.copy()
    moved.loc[row:, [f"controller.path.x[{i}]" for i in range(1, 16)]] += 20.0
    assert {"jump", "return"} <= case.breaches(moved).keys()
    moved = frame.copy()
    moved.loc[row:, "plant.state.y"] += 3.0
    assert "lost" in case.breaches(moved)
