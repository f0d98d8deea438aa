"""Options of `macrostep run` reach the run."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from fmus.export.build import build
from fmus.toolchain.version import Version
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import simulate
from tests.fmus.foreign import description3, library, pack
from tests.orchestrator import ssps
from tests.orchestrator.blocks import Affine

pytestmark = pytest.mark.usefixtures("without_pictures")


def test_algorithm_and_step_reach_the_run(macrostep, in_tmp_path):
    options = ("--blocks", "--step", 0.05, "--stop-time", 0.5, "--algorithm", "jacobi", "--out", "r")
    assert macrostep("run", "static", *options)[0] == 0
    made = prepare("static", Options(mode="blocks", step=0.05, stop_time=0.5))
    expected = simulate(made.system, h=0.05, until=0.5, algorithm="jacobi")
    pd.testing.assert_frame_equal(pd.read_parquet("r/signals.parquet"), expected, check_exact=True)
    told = json.loads((in_tmp_path / "r" / "summary.json").read_text())
    assert told["experiment"] == {"step": 0.05, "stop_time": 0.5, "ticks": 11}


def test_a_single_fmu_runs_and_may_die_in_a_process_of_its_own(macrostep, in_tmp_path):
    y = ['<Float64 name="y" valueReference="101" causality="output"/>']
    text = description3(y, ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>'])
    source = '#define STATUS (t > 0.25 ? *(volatile int *)8 : 0)\n#include "echo3.c"'
    pack(in_tmp_path / "m.fmu", Version.FMI3, text, library(in_tmp_path / "made", Version.FMI3, source))
    code, _, err = macrostep("run", "m.fmu", "--stop-time", 1, "--isolate", "fmu:30", "--out", "r")
    assert code == 1
    assert "tick 3 (t = 0.3 s), unit `fmu`: its process died in `step` (SIGSEGV)" in " ".join(err.split())
    assert pd.read_parquet("r/signals.parquet")["time"].tolist() == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_a_loop_of_an_ssp_is_solved_on_request_only(macrostep, in_tmp_path):
    """a shows b / 4 + 3, and b twice of a: a is 6, b is 12."""
    values = {"a": {"k": 0.25, "d": 3.0}, "b": {"k": 2.0, "d": 0.0}}
    files = {f"resources/{n}.fmu": build(Affine, Version.FMI2, v, in_tmp_path / n).path for n, v in values.items()}
    ends = ssps.connectors("a.value:input", "b.value:output")
    elements = "".join(ssps.component(name, f"{name}.fmu", ends) for name in values)
    wires = ssps.wire("a.b.value", "b.a.value") + ssps.wire("b.b.value", "a.a.value")
    ssps.write(in_tmp_path / "loop.ssp", ssps.body(elements, wires), files)
    code, _, err = macrostep("run", "loop.ssp", "--out", "r")
    assert (code, "algebraic loop: found " in err, "--solve-loops" in err) == (2, True, True)
    assert macrostep("run", "loop.ssp", "--out", "r", "--solve-loops")[0] == 0
    frame = pd.read_parquet("r/signals.parquet")
    assert frame["a.b.value"].tolist() == pytest.approx([6.0] * 4, abs=1e-9)
    assert frame["b.b.value"].tolist() == pytest.approx([12.0] * 4, abs=1e-9)


def test_a_run_can_be_watched_without_a_viewer_here(macrostep):
    code, _, err = macrostep("run", "idle", "--blocks", "--stop-time", 0.2, "--live", "--no-viewer")
    assert code == 0
    assert "live at rerun+http://127.0.0.1:" in err
    code, _, err = macrostep("run", "idle", "--blocks", "--no-viewer")
    assert (code, err) == (2, "macrostep: --no-viewer: found no --live; valid: with --live only\n")
