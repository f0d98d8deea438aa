"""The summary of a run; what it says of mapped FMUs is shown in `test_mapped`, whole run folders in `test_main`."""

from __future__ import annotations

import json

import numpy as np
import pytest

from orchestrator.results import summary
from orchestrator.results.provenance import facts
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation, SimulationError

FAULT = SimulationError(3, 0.3, "plant", "it is gone")


def content(record=None, ended=None):
    scenario = prepare("static", Options(mode="blocks"))
    choice = {"record": record} if record else {}
    with Simulation(scenario.system, h=scenario.h, until=0.5, **choice) as simulation:
        simulation.run()
        return summary.summary(scenario, simulation, simulation.columns(), ended)


def test_a_summary_tells_what_was_run_and_how_it_went():
    told = content()
    assert (told["status"], told["experiment"]["ticks"]) == ("finished", 6)
    assert told["units"]["plant"] == {"kind": "bicycle", "socket": "plant", "runs_as": "block in this process"}
    assert {"gap_edge", "gap_obstacle", "path_error_rms", "mu_f_max", "solver_kkt_max"} <= told["metrics"].keys()
    assert told["verdicts"]["no_contact"] is True
    assert "fault" not in told
    assert facts(told)["status"] == "finished"


def test_signals_that_were_not_kept_at_every_tick_have_no_metrics():
    told = content({"plant.*": 1, "controller.*": 2})
    assert "r_peak" in told["metrics"]
    assert not {"path_error_rms", "gap_obstacle"} & told["metrics"].keys()


@pytest.mark.parametrize(
    ("ended", "status"), [(None, "finished"), (FAULT, "fault"), (KeyboardInterrupt(), "interrupted")]
)
def test_how_a_run_ended_is_one_word(ended, status):
    assert summary.status(ended) == summary.ending(ended)["status"] == status


def test_a_fault_is_told_with_its_place():
    fault = content(ended=FAULT)["fault"]
    assert fault == {"tick": 3, "time": 0.3, "unit": "plant", "reason": "it is gone"}
    assert summary.ending(FAULT) == {
        "status": "fault",
        "fault": "unit `plant`: it is gone",
        "fault at": "tick 3 (t = 0.3 s)",
    }


def test_a_summary_is_written_as_plain_json(tmp_path):
    summary.write_summary({"a": np.float64(0.5), "b": np.int32(2)}, tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text()) == {"a": 0.5, "b": 2}
    with pytest.raises(TypeError, match="set in a summary"):
        summary.write_summary({"a": {1}}, tmp_path)
