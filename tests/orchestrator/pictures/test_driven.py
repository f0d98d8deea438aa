"""Inputs that follow a table are in the recording too (`driven.py`), also in one that is made anew from the rows."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.progress import SILENT
from orchestrator.execution import execute
from orchestrator.loading import load
from orchestrator.recording.series_reader import read_series
from orchestrator.results.run_folder import find
from orchestrator.scenario.options import Options
from orchestrator.viewing import repair
from tests.orchestrator.ssps import echo

INPUTS = (
    ("v", "Real", "0"),
    ("n", "Integer", "0"),
    ("name", "String", "-"),
    ("x[1]", "Real", "0"),
    ("x[2]", "Real", "0"),
)
TABLE = "time,v,n,name,x[2]\n0,0,1,a,-1\n0.2,20,2,b,-1\n0.4,0,3,c,-3\n"


@pytest.mark.parametrize("anew", [False, True])
def test_what_a_table_gives_is_recorded_as_the_rows_have_it(tmp_path, anew):
    (tmp_path / "inputs.csv").write_text(TABLE)
    made = load(str(echo(tmp_path / "a.fmu", INPUTS)), Options(stop_time=0.4, input=tmp_path / "inputs.csv"))
    execute(made, tmp_path / "r", SILENT)
    recording = tmp_path / "r" / "recording.rrd"
    if anew:
        recording.unlink()
        recording = repair.whole_recording(find(tmp_path / "r"), tmp_path, lambda _: None)
    series, frame = read_series(recording), pd.read_parquet(tmp_path / "r" / "signals.parquet")
    for name in ("v", "n", "x[2]"):
        ticks, values = series[f"/signals/fmu/{name}".replace("[", "\\[").replace("]", "\\]")]
        assert ticks.tolist() == [0, 1, 2, 3, 4]
        np.testing.assert_allclose(values.ravel(), frame[f"fmu.{name}"])
    assert "/signals/fmu/name" not in series
