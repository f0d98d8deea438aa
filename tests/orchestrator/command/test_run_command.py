"""`macrostep run`, as a person types it: what it prints, what it leaves behind, how its options reach the run."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest

from fmus.export.build import build
from fmus.toolchain.version import Version
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.whole_run import simulate
from tests.fmus.foreign import copied, description3, entries, library, pack
from tests.orchestrator import ssps
from tests.orchestrator.blocks import Affine

NO_PICTURES = pytest.mark.usefixtures("without_pictures")


@NO_PICTURES
def test_algorithm_and_step_reach_the_run(macrostep, in_tmp_path):
    options = ("--blocks", "--step", 0.05, "--stop-time", 0.5, "--algorithm", "jacobi", "--out", "r")
    assert macrostep("run", "static", *options)[0] == 0
    made = prepare("static", Options(mode="blocks", step=0.05, stop_time=0.5))
    expected = simulate(made.system, h=0.05, until=0.5, algorithm="jacobi")
    pd.testing.assert_frame_equal(pd.read_parquet("r/signals.parquet"), expected, check_exact=True)
    told = json.loads((in_tmp_path / "r" / "summary.json").read_text())
    assert told["experiment"] == {"step": 0.05, "stop_time": 0.5, "ticks": 11}


@NO_PICTURES
def test_a_single_fmu_runs_and_may_die_in_a_process_of_its_own(macrostep, in_tmp_path):
    y = ['<Float64 name="y" valueReference="101" causality="output"/>']
    text = description3(y, ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>'])
    source = '#define STATUS (t > 0.25 ? *(volatile int *)8 : 0)\n#include "echo3.c"'
    pack(in_tmp_path / "m.fmu", Version.FMI3, text, library(in_tmp_path / "made", Version.FMI3, source))
    code, _, err = macrostep("run", "m.fmu", "--stop-time", 1, "--isolate", "fmu:30", "--out", "r")
    assert code == 1
    assert "tick 3 (t = 0.3 s), unit `fmu`: its process died in `fmi3DoStep` (SIGSEGV)" in " ".join(err.split())
    assert pd.read_parquet("r/signals.parquet")["time"].tolist() == pytest.approx([0.0, 0.1, 0.2, 0.3])


@NO_PICTURES
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


@NO_PICTURES
def test_a_run_can_be_watched_without_a_viewer_here(macrostep):
    code, _, err = macrostep("run", "idle", "--blocks", "--stop-time", 0.2, "--live", "--no-viewer")
    assert code == 0
    assert "live in the browser at http://127.0.0.1:" in err
    code, _, err = macrostep("run", "idle", "--blocks", "--no-viewer")
    assert (code, err) == (2, "macrostep: --no-viewer: found no --live; valid: with --live only\n")


def test_a_run_leaves_a_complete_folder(macrostep, in_tmp_path):
    code, out, _ = macrostep("run", "static", "--blocks", "--stop-time", 1.0)
    assert code == 0
    folder = in_tmp_path / "runs" / "static-1"
    found = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    assert {"signals.parquet", "recording.rrd", "summary.json", "system.ssp", "figures/trajectory.png"} <= found
    assert "no contact" in out
    assert "runs/static-1/" in out


def test_a_run_imports_nothing_slow_that_it_has_no_need_of(in_tmp_path):
    script = (
        "import sys; from orchestrator.command import main\n"
        "try: main.main()\n"
        "except SystemExit: print(*{'pandas', 'rerun', 'scipy.optimize', 'matplotlib.pyplot'} & {*sys.modules})"
    )
    command = [sys.executable, "-c", script, "run", "static", "--blocks", "--stop-time", "1", "--out", "r"]
    said = subprocess.run(command, check=True, capture_output=True, text=True)
    assert said.stdout.splitlines()[-1] == ""
    assert (in_tmp_path / "r" / "summary.json").is_file()


@NO_PICTURES
def test_the_next_run_takes_the_next_number(macrostep, in_tmp_path):
    for _ in range(2):
        macrostep("run", "idle", "--blocks")
    assert sorted(p.name for p in (in_tmp_path / "runs").iterdir()) == ["idle-1", "idle-2"]


@NO_PICTURES
def test_signals_carry_their_units_and_the_summary_its_provenance(macrostep, in_tmp_path):
    macrostep("run", "static", "--blocks", "--out", "r", "--set", "plant.m=2100", "--stop-time", 0.5)
    schema = pq.read_schema("r/signals.parquet")
    assert schema.field("plant.state.v_x").metadata[b"unit"] == b"m/s"
    assert schema.field("controller.actuation.T_r").metadata[b"unit"] == b"N.m"
    assert json.loads(schema.field("controller.solver.status").metadata[b"items"]) == {
        "converged": 1,
        "iteration_limit": 2,
        "fallback": 3,
    }
    told = json.loads((in_tmp_path / "r" / "summary.json").read_text())
    assert told["status"] == "finished"
    assert told["parameters"]["plant.m"] == {"value": 2100, "unit": "kg", "source": "--set"}
    assert told["parameters"]["plant.l_f"] == {"value": 1.2, "unit": "m", "source": "paper, Table 1"}
    assert told["experiment"] == {"step": 0.1, "stop_time": 0.5, "ticks": 6}
    assert {"macrostep", "python", "casadi", "fmpy", "numpy", "rerun-sdk"} <= told["versions"].keys()


@NO_PICTURES
@pytest.mark.parametrize("how", [["--blocks"], ["--fmi", "2"], ["--fmi", "3"]])
def test_a_run_can_be_repeated_from_its_folder_alone(macrostep, built_fmus, how):
    macrostep("run", "static", *how, "--set", "controller.b_3=2e-2", "--out", "first")
    code, _, _ = macrostep("run", "first", "--out", "second")
    assert code == 0
    assert pd.read_parquet("first/signals.parquet").equals(pd.read_parquet("second/signals.parquet"))
    first, second = (json.loads(Path(r, "summary.json").read_text()) for r in ("first", "second"))
    assert {**first, "timing": 0} == {**second, "timing": 0}


@NO_PICTURES
def test_a_former_run_is_replaced_and_anything_else_stays(macrostep, in_tmp_path):
    for _ in range(2):
        assert macrostep("run", "idle", "--blocks", "--out", "r")[0] == 0
    (in_tmp_path / "mine").mkdir()
    (in_tmp_path / "mine" / "thesis.txt").write_text("years of work")
    code, _, err = macrostep("run", "idle", "--blocks", "--out", "mine")
    assert code == 2
    assert "mine: found a folder with other things in it; valid: a folder that is new" in err
    assert (in_tmp_path / "mine" / "thesis.txt").exists()


def test_an_output_folder_that_is_a_file_or_cannot_be_made_is_refused(macrostep, in_tmp_path):
    (in_tmp_path / "file").write_text("x")
    code, _, err = macrostep("run", "idle", "--blocks", "--out", "file")
    assert (code, "file: found a file; valid: a folder" in err) == (2, True)
    code, _, err = macrostep("run", "idle", "--blocks", "--out", "file/run")
    assert (code, "found a folder that cannot be written to (Not a directory)" in err) == (2, True)


@NO_PICTURES
def test_a_fault_is_exit_code_1_and_keeps_every_row(macrostep, in_tmp_path):
    code, _, err = macrostep("run", "static", "--blocks", "--set", "plant.C_alpha_f=1e300", "--out", "r")
    assert code == 1
    assert "the run ended in a fault at tick " in err
    assert "unit `plant`: the signal `plant." in err
    told = json.loads((in_tmp_path / "r" / "summary.json").read_text())
    assert told["status"] == "fault"
    assert told["fault"]["unit"] == "plant"
    assert len(pd.read_parquet("r/signals.parquet")) == told["fault"]["tick"] + 1


def test_an_fmu_without_its_library_is_refused_before_anything_is_written(macrostep, in_tmp_path, built_fmus):
    whole = built_fmus / "fmi3" / "bicycle.fmu"
    copied(whole, Path("bare.fmu"), {n: None for n in entries(whole) if n.startswith(("binaries/", "sources/"))})
    code, _, err = macrostep("run", "static", "--blocks", "--plant", "bare.fmu", "--out", "r")
    assert (code, "bare.fmu: found no binary and no sources; valid: a binary for " in err) == (2, True)
    assert not (in_tmp_path / "r").exists()


@NO_PICTURES
def test_an_fmu_that_breaks_a_rule_runs_leniently_and_a_note_says_which(macrostep, built_fmus):
    whole = built_fmus / "fmi3" / "bicycle.fmu"
    text = entries(whole)["modelDescription.xml"]
    text = text.replace(b"<fmiModelDescription ", b'<fmiModelDescription maker="me" ')
    copied(whole, Path("odd.fmu"), {"modelDescription.xml": text})
    options = ("run", "static", "--blocks", "--plant", "odd.fmu", "--stop-time", 0.5, "--out", "r")
    code, _, err = macrostep(*options)
    assert (code, "odd.fmu, modelDescription.xml, line 2: found Element" in err, "--lenient" in err) == (2, True, True)
    code, _, err = macrostep(*options, "--lenient")
    assert (code, "note: plant: odd.fmu: modelDescription.xml, line 2: Element" in err) == (0, True)


@pytest.mark.parametrize(
    ("description", "text"),
    [
        (None, "some.fmu: found an archive without modelDescription.xml"),
        ("<fmi", "some.fmu, modelDescription.xml, line 1: found XML that is not well-formed"),
        ("<html/>", "found a description of no FMU (its root is `html`)"),
        ('<fmiModelDescription fmiVersion="0.9"/>', "found FMI version 0.9; valid: 1.0, 2.0 or 3.0"),
        ('<fmiModelDescription fmiVersion="2.0"/>', "found no interface type; valid: Co-Simulation or Model Exchange"),
    ],
)
def test_a_file_that_is_no_fmu_is_told_why(macrostep, description, text):
    with zipfile.ZipFile("some.fmu", "w") as archive:
        archive.writestr("readme.txt" if description is None else "modelDescription.xml", description or "x")
    code, _, err = macrostep("run", "static", "--blocks", "--plant", "some.fmu")
    assert (code, text in err) == (2, True)


def test_a_run_that_would_not_fit_into_memory_is_refused(macrostep):
    code, _, err = macrostep("run", "static", "--blocks", "--stop-time", "1e9")
    assert code == 2
    assert "stop time: found 10000000001 ticks" in err


@NO_PICTURES
def test_a_run_that_was_cut_short_is_repeated_with_a_note(macrostep, in_tmp_path):
    macrostep("run", "idle", "--blocks", "--out", "r")
    (in_tmp_path / "r" / "summary.json").unlink()
    assert "note: that run was cut short" in macrostep("run", "r", "--out", "again")[2]


@NO_PICTURES
def test_a_run_that_keeps_pace_says_how_well(macrostep):
    code, out, _ = macrostep("run", "idle", "--blocks", "--stop-time", 0.2, "--realtime", 4)
    assert code == 0
    assert ", at 4 x real time (" in out
    _, out, _ = macrostep("run", "idle", "--blocks", "--stop-time", 0.2, "--realtime", 1e6)
    assert re.search(r", at 1e\+06 x real time \([123] ticks late, the worst by \d+\.\d ms\)", " ".join(out.split()))
    code, _, err = macrostep("run", "idle", "--blocks", "--realtime", 0)
    assert (code, "--realtime: found 0; valid: a positive number" in err) == (2, True)


@NO_PICTURES
def test_a_choice_of_what_is_recorded_is_kept_and_repeated(macrostep, in_tmp_path):
    code, _, err = macrostep("run", "static", "--blocks", "--out", "a", "--record", "plant.state.*", "--stop-time", 1.0)
    assert code == 0
    assert "note: not every signal is recorded at every tick; what is computed from it is left out" in err
    assert macrostep("run", "a", "--out", "b")[0] == 0
    first, second = pd.read_parquet("a/signals.parquet"), pd.read_parquet("b/signals.parquet")
    assert list(first) == ["time", *(f"plant.state.{name}" for name in ("x", "y", "psi", "v_x", "v_y", "r"))]
    assert first.equals(second)
    code, _, err = macrostep("run", "static", "--blocks", "--out", "c", "--record", "plant.stat")
    assert (code, "record plant.stat: found a pattern that no signal fits" in err) == (2, True)
    assert not (in_tmp_path / "c").exists()


@NO_PICTURES
def test_a_solver_that_did_not_converge_is_told_with_the_number_of_samples(macrostep, in_tmp_path):
    code, out, _ = macrostep("run", "static-plus", "--out", "r")
    metrics = json.loads((in_tmp_path / "r" / "summary.json").read_text())["metrics"]
    assert code == 0
    assert metrics["solver_limits"] > 0
    assert f"  solver_limits           {metrics['solver_limits']:.0f} of 114 samples\n" in out
    assert "solver_fallbacks" not in out
