"""A real Dask cluster on this machine as the workforce of a sweep, and the files that it is sent (`sent_files.py`)."""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import ExitStack
from functools import partial

import pandas as pd
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.scenario import catalogue
from orchestrator.scenario.options import Options
from orchestrator.scenario.scenario_template import scenario_template
from orchestrator.sweeping import cluster
from orchestrator.sweeping.engine import DIED, workforce
from orchestrator.sweeping.results_table import results_table
from orchestrator.sweeping.sweep import run_sweep
from orchestrator.sweeping.sweep_request import SweepRequest
from tests.orchestrator.exchange.passport.measured_fmus import lag
from tests.orchestrator.sweeping.test_cluster_file import LOCAL

pytest.importorskip("distributed")
REQUEST = SweepRequest("static", ("plant.m=1500:2500",), "lhs:40", seed=3, options=Options(stop_time=3.0))


@pytest.fixture
def dask(tmp_path):
    """Starts a scheduler and workers, each a process that listens on loopback; gives its address and the workers."""
    with ExitStack() as running:

        def start(*arguments):
            line = [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:], "--no-dashboard"]
            process = subprocess.Popen(line, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, cwd=tmp_path)
            running.enter_context(process)
            running.callback(process.kill)
            return process

        def cluster(workers):
            scheduler = start("scheduler", "--host", "127.0.0.1", "--port", "0")
            lines = iter(scheduler.stderr.readline, "")
            address = next(found[0] for line in lines if (found := re.search(r"tcp://127\.0\.0\.1:\d+", line)))
            one = (
                "worker",
                address,
                "--nthreads",
                "1",
                "--host",
                "127.0.0.1",
                "--no-nanny",
                "--local-directory",
                str(tmp_path),
            )
            started = [start(*one) for _ in range(workers)]
            for worker in started:
                assert any("Registered to" in line for line in iter(worker.stderr.readline, ""))
            return address, started

        yield cluster


def values(done):
    return results_table(done.planned, done.results).drop(columns="seconds")


@pytest.fixture(scope="module")
def reference(built_fmus, tmp_path_factory):
    return values(run_sweep(REQUEST, partial(workforce, "threads", 1), tmp_path_factory.mktemp("s") / "s", (), SILENT))


@pytest.mark.slow
def test_two_workers_give_the_same_bits(reference, dask, in_tmp_path):
    address, _ = dask(2)
    done = run_sweep(REQUEST, partial(workforce, address, None), None, (), SILENT)
    pd.testing.assert_frame_equal(values(done), reference, check_exact=True)


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_nothing(reference, dask, in_tmp_path):
    address, workers = dask(3)
    force = partial(workforce, address, None)
    seen = []

    class Killing:
        """Kills a worker when the first results have come."""

        def now(self, text):
            if callable(text):
                seen.append(text)

        def done(self, text):
            pass

    original = cluster._Cluster.submit

    def submit(self, fn, /, *arguments, **more):
        if len(seen) and workers[0].poll() is None and seen[-1]().split()[0] not in {"0", "1"}:
            workers[0].kill()
        return original(self, fn, *arguments, **more)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cluster._Cluster, "submit", submit)
        done = run_sweep(REQUEST, force, None, (), Killing())
    assert workers[0].wait(10) != 0
    pd.testing.assert_frame_equal(values(done), reference, check_exact=True)


@pytest.mark.slow
@pytest.mark.foreign
def test_fmus_that_crash_cost_one_row(dask, in_tmp_path):
    lag(in_tmp_path, "#define STEP if (i->T > 0.95) abort();")
    address, _ = dask(2)
    request = SweepRequest("m.fmu", ("fmu.T=0.02:1",), grid="10", options=Options(stop_time=0.5))
    table = values(run_sweep(request, partial(workforce, address, None), None, (), SILENT))
    assert list(table["status"]) == ["finished"] * 9 + ["fault"]
    assert "SIGABRT" in table["fault"][9]


@pytest.mark.slow
@pytest.mark.foreign
def test_fmus_that_end_their_workers_cost_their_own_rows_only(in_tmp_path):
    """Workers die with what they hold, and a cluster gives up on all that was on a worker that dies."""
    lag(in_tmp_path, "#define STEP if (i->T > 0.9) abort();")
    (in_tmp_path / "c.toml").write_text(LOCAL)
    request = SweepRequest("m.fmu", ("fmu.T=0.1:1",), grid="10", options=Options(stop_time=0.5, in_process=True))
    done = run_sweep(request, partial(workforce, "c.toml", None), None, ("worst:1", "0"), SILENT)
    assert [result.fault for _, result in sorted(done.results.items())] == [""] * 9 + [DIED]
    assert list(done.kept) == [0]
    assert "variant 9 is not kept: it ends the process that runs it" in done.remarks
    assert done.is_whole


@pytest.mark.slow
@pytest.mark.foreign
def test_the_files_that_a_sweep_needs_are_sent(dask, in_tmp_path, monkeypatch):
    """A scenario file, the mapping file and the FMU that it names, and another unit are gone when workers begin."""
    mine = in_tmp_path / "mine"
    mine.mkdir()
    for name in ("bicycle", "bicycle_saturated"):
        (mine / f"{name}.fmu").write_bytes((catalogue.built_folder() / "fmi2" / f"{name}.fmu").read_bytes())
    (mine / "map.toml").write_text('fmu = "bicycle.fmu"\n')
    text = scenario_template("static", mine / "mine.toml")
    before, _, after = text.partition("[plant]\n")
    after = after.partition("[plant.parameters]")[2].partition("\n[")
    (mine / "mine.toml").write_text(f'{before}[plant]\nmapping = "map.toml"\n[plant.parameters]{after[0]}\n[{after[2]}')
    request = SweepRequest("mine/mine.toml", ("plant.m=1500,1600",), options=Options(stop_time=2.0))
    other = SweepRequest("mine/mine.toml", ("plant=mine/bicycle_saturated.fmu",), options=Options(stop_time=2.0))
    expected = [values(run_sweep(one, partial(workforce, "threads", 1), None, (), SILENT)) for one in (request, other)]
    address, _ = dask(1)
    read, shutdown = cluster.read_files, cluster._Cluster.shutdown

    def gone(paths):
        found = read(paths)
        mine.rename(in_tmp_path / "gone")
        return found

    def back(self, **how):
        shutdown(self, **how)
        (in_tmp_path / "gone").rename(mine)

    monkeypatch.setattr(cluster, "read_files", gone)
    monkeypatch.setattr(cluster._Cluster, "shutdown", back)
    for one, table in zip((request, other), expected, strict=True):
        found = values(run_sweep(one, partial(workforce, address, None), None, (), SILENT))
        assert list(found["status"]) == ["finished"] * len(found)
        pd.testing.assert_frame_equal(found, table, check_exact=True)


@pytest.mark.slow
def test_workers_with_another_version_are_refused(dask, monkeypatch):
    address, _ = dask(1)
    monkeypatch.setattr(cluster, "own_version", lambda: "9.9")
    with pytest.raises(RequestError) as error:
        workforce(address, None)
    assert "valid: macrostep 9.9. Install the same version on all machines." in str(error.value)


@pytest.mark.slow
def test_a_cluster_without_workers_is_refused(dask):
    address, _ = dask(0)
    with pytest.raises(RequestError, match="found a cluster without workers; valid: one with workers"):
        workforce(address, None)


def test_a_scheduler_that_is_not_there_is_refused(monkeypatch):
    monkeypatch.setattr(cluster, "_ANSWERS_WITHIN", 0.2)
    with pytest.raises(RequestError) as error:
        workforce("tcp://127.0.0.1:9", None)
    assert str(error.value).startswith("--on tcp://127.0.0.1:9: found nobody who answers (")
