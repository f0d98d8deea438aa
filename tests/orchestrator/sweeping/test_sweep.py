"""Sweeps from a request to a folder, by every workforce: the same bits, whoever works, and whatever dies on the way.

Shows `sweep.py`, `sweep_request.py`, `sweep_folder.py`, `results_table.py`, `engine.py`, `work.py`, `kept_scenario.py`,
`plan.py`, `tally.py` and `sweep_command.py`.
"""

from __future__ import annotations

import json
import re
import shlex
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pandas as pd
import pytest
from msgspec import structs

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.results.run_folder import SIGNALS
from orchestrator.scenario.options import Options
from orchestrator.sweeping import sweep_folder, work
from orchestrator.sweeping.engine import DIED, workforce
from orchestrator.sweeping.findings import command
from orchestrator.sweeping.journal import VariantResult, read_journal, write_journal
from orchestrator.sweeping.plan import plan
from orchestrator.sweeping.sweep import go_on, run_sweep, sweep
from orchestrator.sweeping.sweep_request import SweepRequest, absolute
from orchestrator.sweeping.tally import Tally
from tests.orchestrator.exchange.passport.measured_fmus import lag
from tests.waiting import wait_until

SHORT = Options(stop_time=3.0)
VARIED = {"plant.m": "1500:2500", "traffic.x_start[1]": "40:60", "scene.y_left": [5.0, 5.25]}
ASKED = {"samples": "sobol:12", "seed": 7, "options": SHORT}


def values(table):
    """A table without the only column that differs from one sweep to the next."""
    return table.drop(columns="seconds")


@pytest.fixture(scope="module")
def reference(built_fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweeps") / "reference"
    return sweep("static", VARIED, **ASKED, out=folder, executor=ThreadPoolExecutor(1), keep=("worst:2", "3"))


def test_a_row_for_each_variant_with_its_values_metrics_verdicts_and_time(reference):
    assert list(reference["variant"]) == list(range(12))
    assert reference["plant.m"].between(1500, 2500).all()
    assert set(reference["scene.y_left"]) == {5.0, 5.25}
    assert (reference["status"] == "finished").all()
    assert (reference["fault"] == "").all()
    assert reference["gap_obstacle"].notna().all()
    assert str(reference["no_contact"].dtype) == "boolean"
    assert (reference["seconds"] > 0).all()


def test_the_folder_has_the_tables_the_report_and_the_runs_that_are_kept(reference):
    folder = Path(reference.attrs["folder"])
    found = {path.name for path in folder.iterdir()} - {".lock", "manifest.json"}
    assert found == {"samples.parquet", "metrics.parquet", "bands.parquet", "sweep.json", "report.html", "runs"}
    pd.testing.assert_frame_equal(pd.read_parquet(folder / "metrics.parquet"), reference, check_exact=True)
    samples = pd.read_parquet(folder / "samples.parquet")
    pd.testing.assert_frame_equal(samples, reference[["variant", *VARIED]])
    told = json.loads((folder / "sweep.json").read_text())
    assert (told["status"], told["variants"], told["sampling"]) == ("finished", 12, "--samples sobol:12")
    assert told["request"]["seed"] == 7
    assert told["varied"]["plant.m"] == {"values": "1500:2500", "unit": "kg"}
    assert told["units"]["plant"]["sha256"]
    assert len(told["kept"]) == len(list((folder / "runs").iterdir())) >= 2


def test_a_run_that_is_kept_is_that_of_its_command_and_has_the_metrics_of_its_row(reference, macrostep, in_tmp_path):
    folder = Path(reference.attrs["folder"])
    planned = plan(sweep_folder.asked(folder)["request"])
    kept = folder / "runs" / "variant-3"
    line = command(planned, 3)
    assert line.startswith("macrostep run static --stop-time 3.0 --set plant.m=")
    code, _, _ = macrostep(*shlex.split(line)[1:], "--out", "again")
    assert code == 0
    for name in (SIGNALS, "system.ssp"):
        assert (kept / name).read_bytes() == (in_tmp_path / "again" / name).read_bytes()
    told = json.loads((kept / "summary.json").read_text())
    row = reference.iloc[3]
    assert told["metrics"] == {name: row[name] for name in told["metrics"]}
    assert told["verdicts"] == {name: bool(row[name]) for name in told["verdicts"]}


@pytest.mark.parametrize("made", [lambda: ThreadPoolExecutor(2), lambda: None], ids=["two threads", "processes"])
def test_the_same_bits_whoever_works(reference, made, in_tmp_path):
    table = sweep("static", VARIED, **ASKED, executor=made(), keep=())
    pd.testing.assert_frame_equal(values(table), values(reference), check_exact=True)
    assert table.attrs["folder"] == "runs/static-sweep-1"


@pytest.mark.slow
def test_an_executor_that_a_person_brings_goes_on(reference, in_tmp_path):
    with ProcessPoolExecutor(2) as executor:
        table = sweep("static", VARIED, **ASKED, executor=executor, keep=())
        assert executor.submit(pow, 2, 3).result() == 8
    pd.testing.assert_frame_equal(values(table), values(reference), check_exact=True)


@pytest.mark.foreign
@pytest.mark.slow
@pytest.mark.parametrize("in_process", [False, True], ids=["isolated", "in the worker"])
def test_one_variant_that_crashes_costs_one_row(in_tmp_path, in_process):
    lag(in_tmp_path, "#define STEP if (i->T > 0.95) abort();")
    options = Options(in_process=in_process, stop_time=0.5)
    table = sweep("m.fmu", {"fmu.T": "0.02:1 [s]"}, grid="20", options=options, keep=())
    (bad,) = table.index[table["status"] == "fault"]
    assert bad == 19
    assert list(table["variant"]) == list(range(20))
    expected = DIED if in_process else "SIGABRT"
    assert expected in table["fault"][bad]


@pytest.mark.foreign
@pytest.mark.slow
def test_a_variant_that_hangs_costs_one_row(in_tmp_path):
    lag(in_tmp_path, "#define STEP while (i->T > 0.9);")
    options = Options(isolate=["fmu:1"], stop_time=0.5)
    table = sweep("m.fmu", {"fmu.T": [0.1, 0.5, 1.0]}, options=options, keep=())
    assert list(table["status"]) == ["finished", "finished", "fault"]
    assert "within 1 s" in table["fault"][2]


def test_what_fills_a_socket_varies_as_well(built_fmus, in_tmp_path):
    plants = ["bicycle", str(built_fmus / "fmi2" / "bicycle_saturated.fmu")]
    varied = {"plant": plants, "plant.mu": [0.5, 0.9]}
    table = sweep("static", varied, options=SHORT, executor=ThreadPoolExecutor(1), keep=())
    assert list(table["plant"]) == [plants[0]] * 2 + [plants[1]] * 2
    assert table["r_peak"].nunique() >= 3
    assert (table["status"] == "finished").all()


def test_a_scenario_file_says_what_varies_where_the_command_does_not(built_fmus, macrostep, in_tmp_path):
    assert macrostep("scenario", "new", "mine.toml")[0] == 0
    file = in_tmp_path / "mine.toml"
    vary = '"plant.v_x_start" = { values = "36:39.6", unit = "km/h" }\n"plant.mu" = { values = [0.7, 0.9] }\n'
    file.write_text(file.read_text() + f'[sweep]\nsamples = "lhs:4"\nseed = 3\n[sweep.vary]\n{vary}')
    assert macrostep("sweep", "mine.toml", "--stop-time", "2", "--on", "threads", "--out", "a")[0] == 0
    table = pd.read_parquet(in_tmp_path / "a" / "metrics.parquet")
    assert table["plant.v_x_start"].between(10, 11).all()
    assert set(table["plant.mu"]) == {0.7, 0.9}
    told = json.loads((in_tmp_path / "a" / "sweep.json").read_text())
    assert (told["variants"], told["request"]["seed"]) == (4, 3)
    line = ("sweep", "mine.toml", "--vary", "plant.m=1500,1600", "--stop-time", "2", "--on", "threads", "--out", "b")
    assert macrostep(*line)[0] == 0
    assert list(pd.read_parquet(in_tmp_path / "b" / "metrics.parquet")["plant.m"]) == [1500.0, 1600.0]
    file.write_text(file.read_text() + '"plant.mm" = { values = "1:2" }\n"plant.m" = { values = "1:2", unit = "m" }\n')
    code, _, err = macrostep("sweep", "mine.toml")
    assert code == 2
    assert "plant.mm: found an unknown parameter" in err
    assert "macrostep: --vary plant.m=1:2 [m]: found `1 [m]`" in err


def test_what_is_refused_in_one_variant_is_its_fault(built_fmus, in_tmp_path, monkeypatch):
    def refuse(*_):
        raise RequestError([])

    monkeypatch.setattr("orchestrator.sweeping.work.KeptScenario.changes", refuse)
    table = sweep("static", {"plant.m": [1500.0]}, options=SHORT, executor=ThreadPoolExecutor(1), keep=())
    assert list(table["fault"]) == ["refused: "]


@pytest.mark.slow
def test_a_sweep_that_is_killed_goes_on_without_losing_or_repeating_a_variant(reference, in_tmp_path):
    arguments = [f"--vary={path}={v if isinstance(v, str) else '5.0,5.25'}" for path, v in VARIED.items()]
    begun = [
        *(sys.executable, "-m", "orchestrator.command.main", "sweep", "static", *arguments),
        *("--samples", "sobol:12", "--seed", "7", "--stop-time", "3", "--out", "s", "--keep", "worst:0"),
    ]
    done = in_tmp_path / "s" / "done"
    for round_ in range(3):
        line = begun if round_ == 0 else [*begun[:4], "s", "--keep", "worst:0"]
        before = len(read_journal(done))
        with subprocess.Popen(line, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
            wait_until(lambda: len(read_journal(done)) > before or process.poll() is not None)  # noqa: B023
            process.send_signal(signal.SIGKILL)
        if not done.is_dir():
            break
    known = read_journal(done)
    result = go_on(in_tmp_path / "s", partial(workforce, "threads", 1), ("worst:0",), SILENT) if done.is_dir() else None
    if result is not None:
        assert known.items() <= result.results.items(), "nothing that was done is done again"
    table = pd.read_parquet(in_tmp_path / "s" / "metrics.parquet")
    pd.testing.assert_frame_equal(values(table), values(reference), check_exact=True)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_a_sweep_in_order_and_says_how_to_go_on(built_fmus, in_tmp_path, number):
    line = ("sweep", "static", "--vary", "plant.m=1500:2500", "--samples", "lhs:2000", "--out", "s")
    command = [sys.executable, "-m", "orchestrator.command.main", *line]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        wait_until(lambda: len(read_journal(in_tmp_path / "s" / "done")) > 3)
        process.send_signal(number)
        *_, interrupted, remedy = process.stderr.read().splitlines()
    assert process.returncode == 130
    done = read_journal(in_tmp_path / "s" / "done")
    assert interrupted == f"macrostep: interrupted after {len(done)} of 2000 variants"
    assert remedy == "Go on with it: macrostep sweep s"
    assert json.loads((in_tmp_path / "s" / "sweep.json").read_text())["status"] == "interrupted"


def test_lines_that_a_killed_process_left_incomplete_are_no_results(tmp_path):
    result = VariantResult(3, 0.1, {"gap_edge": 0.1 + 0.2}, {"no_contact": True})
    write_journal(tmp_path, [result])
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole + b"nonsense\n" + whole.replace(b'"variant":3', b'"variant":4')[:-5])
    assert read_journal(tmp_path) == {3: result}


def stopped(folder):
    """A sweep of which one variant is done."""
    request = SweepRequest("static", ("plant.m=1500,1600,1700",), options=SHORT)
    with sweep_folder.new_sweep(plan(request), folder) as claimed:
        write_journal(claimed.path / "done", [VariantResult(1, 0.5, {"gap_edge": 7.0}, {"inside_road": True})])


def test_what_is_done_is_not_run_again(built_fmus, in_tmp_path):
    stopped(in_tmp_path / "s")
    done = go_on(in_tmp_path / "s", partial(workforce, "threads", 1), (), SILENT)
    assert done.is_whole
    assert done.results[1].metrics == {"gap_edge": 7.0}
    assert 0 < done.results[0].metrics["gap_edge"] < 1


def test_a_sweep_that_was_stopped_and_is_not_what_it_was_is_refused(built_fmus, in_tmp_path, monkeypatch):
    stopped(in_tmp_path / "s")
    file = in_tmp_path / "s" / "sweep.json"
    told = json.loads(file.read_text())

    def refused(**changes):
        file.write_text(json.dumps(told | changes))
        with pytest.raises(RequestError) as error:
            go_on(in_tmp_path / "s", partial(workforce, "threads", 1), (), SILENT)
        return str(error.value)

    assert "s: scenario: found values, times or files that are not those that it began with" in refused(scenarios={})
    request = {**told["request"], "vary": ["plant.m=1500,1600"]}
    assert "samples.parquet: found other values than are asked for now" in refused(request=request)
    assert "found a file that says not what was asked" in refused(request={})
    with pytest.raises(RequestError, match="found a folder without the manifest.json of a sweep"):
        go_on(in_tmp_path, partial(workforce, "threads", 1), (), SILENT)
    with pytest.raises(RequestError, match="found a sweep that was stopped; valid: a sweep that has ended"):
        sweep_folder.read_results(in_tmp_path / "s")


def test_a_line_tells_how_it_goes_and_what_is_left(built_fmus):
    planned = plan(SweepRequest("static", ("plant.m=1500:2500",), "lhs:201", options=SHORT))
    now = iter([0.0, 5.0, 6.0, 100.0, 206.0])
    tally = Tally(planned, {}, lambda: next(now))
    tally.note(VariantResult(0, 1.0, {"gap_edge": 0.5}, {"inside_road": True}))  # workers were ready after 5 s
    assert tally() == "1 of 201 variants; worst so far: variant 0 (gap_edge 0.5 m)"
    for number in range(1, 101):
        tally.note(VariantResult(number, 1.0, {}, {}, "t = 1 s: it died" if number == 7 else ""))
    assert tally() == (
        "101 of 201 variants, 1 with a fault, 1.05 per second, 95 s left; worst so far: variant 7 (t = 1 s: it died)"
    )


def test_the_runs_of_a_former_sweep_go_with_it(built_fmus, in_tmp_path):
    for values, keep in (("plant.m=1500,2500", ("0,1",)), ("plant.m=1600,1700", ("1",))):
        request = SweepRequest("static", (values,), options=SHORT)
        run_sweep(request, partial(workforce, "threads", 1), Path("s"), keep, SILENT)
        (in_tmp_path / "s" / "runs" / "mine.txt").write_text("a person's")
    assert sorted(path.name for path in (in_tmp_path / "s" / "runs").iterdir()) == ["mine.txt", "variant-1"]


@pytest.mark.parametrize("moment", ["execute", "_keep"])
def test_ctrl_c_after_the_last_variant_leaves_a_sweep_that_goes_on(built_fmus, in_tmp_path, monkeypatch, moment):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    request = SweepRequest("static", ("plant.m=1500,2500",), options=SHORT)
    with monkeypatch.context() as patch:
        patch.setattr(f"orchestrator.sweeping.sweep.{moment}", interrupted)
        done = run_sweep(request, partial(workforce, "threads", 1), Path("s"), ("0",), SILENT)
    assert (done.is_whole, len(done.results)) == (False, 2)
    assert not (in_tmp_path / "s" / "report.html").exists()
    assert go_on(Path("s"), partial(workforce, "threads", 1), ("0",), SILENT).is_whole


def test_a_sweep_goes_on_from_any_folder_and_without_its_table(built_fmus, in_tmp_path, monkeypatch):
    plants = {name: (built_fmus / "fmi3" / f"{name}.fmu").read_bytes() for name in ("bicycle", "bicycle_saturated")}
    for name, content in plants.items():
        (in_tmp_path / f"{name}.fmu").write_bytes(content)
    table = in_tmp_path / "cases.csv"
    table.write_text("plant,plant.m [t]\nbicycle.fmu,1.5\nbicycle_saturated.fmu,1.6\n")
    request = absolute(SweepRequest("static", (), "cases.csv", options=SHORT))
    with sweep_folder.new_sweep(plan(request), Path("s")) as claimed:
        folder = claimed.path
    table.unlink()
    (in_tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(in_tmp_path / "elsewhere")
    done = go_on(folder, partial(workforce, "threads", 1), (), SILENT)
    found = sweep_folder.read_results(folder)
    assert list(found["plant.m"]) == [1500.0, 1600.0]
    assert list(found["plant"]) == [str(in_tmp_path / f"{name}.fmu") for name in plants]
    assert [result.fault for result in done.results.values()] == ["", ""]
    (in_tmp_path / "bicycle_saturated.fmu").write_bytes(plants["bicycle"])  # not the first of the units
    with pytest.raises(RequestError, match=r"bicycle_saturated.fmu: found values, times or files that are not those"):
        go_on(folder, partial(workforce, "threads", 1), (), SILENT)


def test_problems_of_a_table_are_told_by_their_rows(built_fmus, in_tmp_path):
    (in_tmp_path / "cases.csv").write_text("plant.m,plant.mu\n1500,0.5\n0,0.5\n1500,9\n")
    with pytest.raises(RequestError) as error:
        sweep("static", {}, samples="cases.csv", options=SHORT)
    assert [str(problem).partition("; ")[0].rpartition("/")[2] for problem in error.value.problems] == [
        "cases.csv, row 2, plant.m: found 0",
        "cases.csv, row 3, plant.mu: found 9",
    ]


def test_more_than_the_disk_can_hold_is_refused_before_anything_runs(built_fmus, in_tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("Free", (), {"free": 5000})())
    with pytest.raises(RequestError) as error:
        sweep("static", {"plant.m": [1500.0, 1600.0, 1700.0]}, options=SHORT)
    assert "found 0 MB of room for 3 variants" in str(error.value)
    assert not list(in_tmp_path.glob("runs/*/*"))


def test_all_that_is_wrong_is_told_at_once(built_fmus, in_tmp_path):
    with pytest.raises(RequestError) as error:
        sweep("static", {"plant.mm": "1:2", "traffic.v_final[99]": "1:2", "sene.x": "1:2", "plant.m": "-3:1"}, seed=-1)
    told = str(error.value)
    assert "--seed: found -1" in told
    assert "plant.mm: found an unknown parameter" in told
    assert "traffic.v_final[99]: found no such element; valid: 1 to 8" in told
    assert "--vary sene.x: found the unknown unit `sene`; valid: a parameter of " in told
    assert "--vary plant.m=-3:1: found -3; valid: 1 <= number [kg]" in told
    assert list(in_tmp_path.iterdir()) == []


def test_the_command_says_what_came_of_it_and_ends_with_0(built_fmus, macrostep, in_tmp_path):
    line = ("static", "--vary", "plant.m=1500:2500", "--samples", "lhs:4", "--stop-time", "3", "--on", "threads")
    code, out, err = macrostep("sweep", *line, "--keep", "worst:1")
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == "static: 4 variants, --samples lhs:4"
    assert re.search(r"  no contact +100.0 %  \(4 of 4; 95 %: 51.0 to 100.0 %\)", out)
    assert re.search(r"  worst +variant \d: ", out)
    assert out.splitlines()[-1].endswith("metrics.parquet  bands.parquet  samples.parquet  sweep.json  runs/ (1)")
    code, _, err = macrostep("sweep", "runs/static-sweep-1", "--vary", "plant.m=1:2", "--stop-time", "3")
    assert code == 2
    assert "macrostep: --vary: found it for a sweep that has begun; valid: only --on, --jobs and --keep" in err
    assert "macrostep: other options: found it for a sweep that has begun" in err
    code, _, err = macrostep("sweep", "runs/static-sweep-1", "--seed", "0", "--budget", "5s")
    assert (code, err.count("found it for a sweep that has begun")) == (2, 2)


def test_a_sweep_that_has_ended_can_be_asked_to_keep_more(built_fmus, in_tmp_path):
    request = SweepRequest("static", ("plant.m=1500,2500",), options=SHORT)
    done = run_sweep(request, partial(workforce, "threads", 1), None, (), SILENT)
    again = go_on(done.folder, partial(workforce, "threads", 1), ("0",), SILENT)
    assert [path.name for path in again.kept.values()] == ["variant-0"]
    assert {n: structs.replace(result, signals={}) for n, result in done.results.items()} == again.results


def test_a_worker_with_another_version_ends_a_sweep_that_goes_on_later(built_fmus, in_tmp_path, monkeypatch):
    request = SweepRequest("static", ("plant.m=1500,1600,2500",), options=SHORT)
    with monkeypatch.context() as other:
        other.setattr(work, "own_version", lambda: "9.9")
        with pytest.raises(RequestError, match="found a worker with macrostep 9.9; valid: macrostep "):
            run_sweep(request, partial(workforce, "threads", 1), None, (), SILENT)
    done = go_on(Path("runs/static-sweep-1"), partial(workforce, "threads", 1), (), SILENT)
    assert [result.fault for result in done.results.values()] == ["", "", ""]


def test_a_script_that_asks_for_a_sweep_runs_once(built_fmus, in_tmp_path):
    """Processes that `multiprocessing` spawns would run it again, each of which would ask for another sweep."""
    (in_tmp_path / "mine.py").write_text(
        "from orchestrator import Options, sweep\n"
        "print('runs')\n"
        "table = sweep('static', {'plant.m': [1500, 1600]}, options=Options(stop_time=0.3), keep=())\n"
        "print(len(table), set(table['status']))\n"
    )
    done = subprocess.run([sys.executable, "mine.py"], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("runs\n2 {'finished'}\n", "")


@pytest.mark.parametrize(
    ("on", "jobs", "told"),
    [
        ("cloud", None, "--on cloud: found an unknown workforce; valid: processes, threads, the address of a Dask"),
        (None, 0, "--jobs: found 0; valid: a whole number, 1 or more"),
    ],
)
def test_a_workforce_that_there_is_not_is_refused(on, jobs, told):
    with pytest.raises(RequestError) as error:
        workforce(on, jobs)
    assert str(error.value).startswith(told)
