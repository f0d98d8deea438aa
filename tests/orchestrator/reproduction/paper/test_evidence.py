from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.buses import VehicleState, Waypoints
from orchestrator.reproduction.paper.evidence import RecordedRun, off_path, sign_changes, trajectory_distance


def recorded(columns):
    return RecordedRun(pd.DataFrame(columns), {VehicleState: "plant.state", Waypoints: "controller.path"})


@pytest.mark.parametrize(
    ("r", "changes"),
    [
        ([0.0, 0.0], 0),
        ([0.3, 0.1, -0.3, 0.3], 2),
        ([0.3, 0.01, -0.01, 0.01, 0.3], 0),  # no swing at all
        ([0.3, -0.04, 0.3], 0),  # no swing to the other side
        ([0.3, 0.0, -0.3], 1),  # through zero
        ([], 0),
    ],
)
def test_sign_changes_count_swings_to_the_other_side(r, changes):
    assert sign_changes(np.array(r)) == changes


def test_the_distance_of_trajectories_is_the_largest_at_the_same_instant():
    a = recorded({"plant.state.x": [0.0, 1.0, 2.0], "plant.state.y": [0.0, 0.0, 0.0]})
    b = recorded({"plant.state.x": [0.0, 4.0], "plant.state.y": [0.0, 4.0]})
    assert trajectory_distance(a, b) == 5.0
    assert trajectory_distance(a, a) == 0.0


def test_the_distance_from_anothers_path_is_taken_at_the_same_instant():
    waypoints = {f"controller.path.x[{i + 1}]": [10.0 * i] * 2 for i in range(15)}
    waypoints |= {f"controller.path.y[{i + 1}]": [0.0, 1.0] for i in range(15)}
    ego = recorded({"plant.state.x": [5.0, 15.0, 25.0], "plant.state.y": [3.0, 1.0, 9.0]})
    assert off_path(ego, recorded(waypoints)) == pytest.approx(np.sqrt(9 / 2))
