"""The folder of a run whose process has died is completed by another one."""

from __future__ import annotations

import json
import subprocess
import sys

import pandas as pd
import pytest

from components.interfaces.problem import RequestError
from orchestrator.results.completion import finish
from orchestrator.results.run_folder import find

DYING = """
import os, sys
import pandas as pd
from pathlib import Path
from components.interfaces.progress import SILENT
from orchestrator import execution
from orchestrator.results import row_files
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare

row_files.INTERVAL = 0.01
at, out = sys.argv[1], Path(sys.argv[2])

def die():
    rows = lambda: len(pd.read_parquet(out / "rows")) if list((out / "rows").glob("part-*")) else 0
    while rows() < 12 and not (out / "signals.parquet").is_file():
        pass
    os._exit(9)

if at == "stepping":
    execution._step = lambda simulation, *_: ([simulation.step() for _ in range(12)], die())
elif at == "closing":
    execution.Simulation.close = lambda _: die()
else:
    execution.LiveFolder.conclude = lambda *_: die()
made = prepare("static", Options(mode="blocks", stop_time=2.0))
execution.execute(made, out, SILENT, execution.Execution(figures=False))
"""


def died(folder, at):
    """A run whose process has died, and its folder."""
    done = subprocess.run([sys.executable, "-c", DYING, at, str(folder)], check=False)
    assert done.returncode == 9
    return folder


def test_a_run_that_died_while_it_stepped_has_its_rows_and_says_why(tmp_path):
    folder = died(tmp_path / "r", "stepping")
    rows = pd.read_parquet(folder / "rows")
    assert find(folder).rows == folder / "rows"
    content = finish(folder, "the process was ended by SIGSEGV", unit="plant")
    tick = len(rows) - 1
    reason = {"tick": tick, "time": tick * 0.1, "unit": "plant", "reason": "the process was ended by SIGSEGV"}
    assert (content["status"], content["fault"]) == ("fault", reason)
    assert content["experiment"]["ticks"] == len(rows)
    assert {"gap_edge", "r_peak"} <= content["metrics"].keys()
    assert content["verdicts"]["inside_road"] is True
    assert json.loads((folder / "summary.json").read_text()) == content
    assert pd.read_parquet(folder / "signals.parquet").equals(rows)
    assert sorted(p.name for p in folder.iterdir()) == [
        ".lock",
        "figures",
        "manifest.json",
        "signals.parquet",
        "summary.json",
        "system.ssp",
    ]
    assert finish(folder, "another reason") == content, "it is complete"


@pytest.mark.parametrize("at", ["closing", "concluding"])
def test_a_run_that_had_come_to_its_end_is_finished_and_says_what_happened_then(tmp_path, at):
    folder = died(tmp_path / "r", at)
    content = finish(folder, "SIGSEGV")
    assert (content["status"], content["closing"]) == ("finished", "SIGSEGV")
    assert "fault" not in content
    assert content["experiment"]["ticks"] == len(pd.read_parquet(folder / "signals.parquet")) == 21
    assert content["metrics"]["gap_edge"] > 0


def test_damaged_facts_and_a_missing_system_leave_the_rows(tmp_path):
    folder = died(tmp_path / "r", "stepping")
    (folder / ".draft.json").write_text("{")
    (folder / "system.ssp").unlink()
    content = finish(folder, "killed")
    assert (content["status"], content["fault"]["reason"], content["metrics"]) == ("fault", "killed", {})
    assert len(pd.read_parquet(folder / "signals.parquet")) >= 1


def test_only_the_folder_of_a_run_is_finished(tmp_path):
    with pytest.raises(RequestError) as error:
        finish(tmp_path, "killed")
    assert str(error.value) == (
        f"{tmp_path}: found a folder without the manifest.json of a run; valid: a folder that a run has written"
    )
    assert list(tmp_path.iterdir()) == []
