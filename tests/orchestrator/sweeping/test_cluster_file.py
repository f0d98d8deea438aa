"""Clusters that are started for a sweep by a file: what is in it, what is refused, and that they end with the sweep.

`dask_jobqueue.SLURMCluster` is the real one; its `sbatch` is a stand-in that runs the job script on this machine,
since a batch system is a service of several programs that run as root.
"""

from __future__ import annotations

import os
import subprocess
from functools import partial

import pandas as pd
import psutil
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.scenario.options import Options
from orchestrator.sweeping.engine import workforce
from orchestrator.sweeping.results_table import results_table
from orchestrator.sweeping.sweep import run_sweep
from orchestrator.sweeping.sweep_request import SweepRequest
from tests.reports import Reports
from tests.waiting import wait_until

pytest.importorskip("distributed")
REQUEST = SweepRequest("static", ("plant.m=1500:2500",), "lhs:12", seed=3, options=Options(stop_time=2.0))
A_CLUSTER = 'cluster = "distributed.LocalCluster"'
LOCAL = """
cluster = "distributed.LocalCluster"
workers = 2
[options]
host = "127.0.0.1"
threads_per_worker = 1
n_workers = 0
dashboard_address = ":0"
"""
SLURM = """
cluster = "dask_jobqueue.SLURMCluster"
workers = 2
[options]
cores = 1
processes = 1
memory = "1GB"
interface = "lo"
walltime = "00:10:00"
scheduler_options = { dashboard_address = ":0" }
"""
SBATCH = """#!/bin/sh
setsid sh "$1" > "$0.$$.log" 2>&1 &
echo $! >> "$0.jobs"
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
for job in "$@"; do kill -- -$job; done
"""


@pytest.fixture
def batch_system(tmp_path, monkeypatch):
    """The commands of Slurm that dask-jobqueue calls; gives the file with the processes of all jobs."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, text in {"sbatch": SBATCH, "scancel": SCANCEL}.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    yield folder / "sbatch.jobs"
    for job in (folder / "sbatch.jobs").read_text().split():
        subprocess.run(["/bin/kill", "--", f"-{job}"], check=False, stderr=subprocess.DEVNULL)


def values(done):
    return results_table(done.planned, done.results).drop(columns="seconds")


@pytest.fixture(scope="module")
def reference(built_fmus, tmp_path_factory):
    return values(run_sweep(REQUEST, partial(workforce, "threads", 1), tmp_path_factory.mktemp("s") / "s", (), SILENT))


@pytest.mark.slow
def test_a_cluster_is_started_for_the_sweep_and_ends_with_it(reference, in_tmp_path):
    (in_tmp_path / "local.toml").write_text(LOCAL)
    told = Reports()
    done = run_sweep(REQUEST, partial(workforce, "local.toml", None, told), None, (), told)
    pd.testing.assert_frame_equal(values(done), reference, check_exact=True)
    assert "waiting for the first of 2 workers of local.toml" in told.texts
    wait_until(lambda: not [p for p in psutil.Process().children(recursive=True) if "distributed" in command_of(p)])


@pytest.mark.slow
def test_on_slurm_the_workers_are_jobs_which_are_cancelled_at_the_end(reference, batch_system, in_tmp_path):
    (in_tmp_path / "slurm.toml").write_text(SLURM)
    done = run_sweep(REQUEST, partial(workforce, "slurm.toml", None), None, (), SILENT)
    pd.testing.assert_frame_equal(values(done), reference, check_exact=True)
    jobs = [int(number) for number in batch_system.read_text().split()]
    assert len(jobs) == 2
    wait_until(lambda: not any(psutil.pid_exists(job) and "dask" in command_of(psutil.Process(job)) for job in jobs))


def command_of(process):
    try:
        return " ".join(process.cmdline())
    except psutil.Error:
        return ""


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("workers = 2", "c.toml: cluster: found nothing; valid: an entry of this name"),
        (f"{A_CLUSTER}\nworkers = 0", "c.toml: workers: found `0`; valid: greater than or equal to 1"),
        (f"{A_CLUSTER}\nworkers = 1\nx = 1", "c.toml: x: found an unknown entry; valid: cluster, options"),
        ('cluster = "..x"\nworkers = 1', "c.toml: cluster: found `..x`; valid: a class of"),
        ('cluster = "SLURM"\nworkers = 1', "c.toml: cluster: found `SLURM`, without its module; valid: a class of"),
        ('cluster = "dask_no.C"\nworkers = 1', "which is not installed (No module named 'dask_no'); valid: a class of"),
        ('cluster = "distributed.Client"\nworkers = 1', "which is no cluster; valid: a class of Dask's projects"),
        (f"{A_CLUSTER}\nworkers = 1\noptions = {{no = 1}}", "c.toml: found a cluster that does not start ("),
    ],
)
def test_a_file_that_starts_nothing_is_refused(content, told, in_tmp_path):
    (in_tmp_path / "c.toml").write_text(content)
    with pytest.raises(RequestError) as error:
        workforce("c.toml", None)
    assert told in str(error.value)


def test_a_file_that_is_not_there_is_refused():
    with pytest.raises(RequestError, match="no such file"):
        workforce("nowhere.toml", None)
