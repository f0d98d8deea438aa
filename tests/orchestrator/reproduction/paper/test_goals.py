"""The goals of `mpc_plus` flip when the metrics do."""

from __future__ import annotations

import pytest

from orchestrator.reproduction.paper import goals
from orchestrator.reproduction.paper.evidence import Evidence
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.paper.verdict import Status
from tests.orchestrator.reproduction.made_results import SMOOTH, mp, result


@pytest.mark.parametrize(
    "metrics",
    [{"gap_obstacle": 0.0}, {"gap_edge": -0.1}, {"path_error_rms": 0.26}, {"r_dot_rms": 0.7}],
    ids=lambda m: next(iter(m)),
)
def test_the_goal_flips_with_contact_edge_accuracy_and_smoothness(metrics):
    def decided(**changed):
        plus = result(RunRole.PLUS, {**SMOOTH, "r_dot_rms": 0.4}, "mpc-plus", **changed)
        return goals.nominal(Evidence((mp(), plus)))

    assert decided().status is Status.HOLDS
    assert decided(**metrics).status is Status.FAILS
    assert decided(**metrics).speaking_against == dict.fromkeys(metrics, 1)
