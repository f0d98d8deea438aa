"""Variants of `static` per second: one worker, two, a Dask cluster, with a plant in a process of its own; and alone.

Run by `uv run pytest tests/bench/test_bench_sweep.py --benchmark-only --benchmark-json FILE`; the file has the rates.
"""

from __future__ import annotations

import time
from dataclasses import replace

import pytest

from components.interfaces.progress import SILENT
from orchestrator import Options, Simulation, load
from orchestrator.sweeping.engine import Engine, workforce
from orchestrator.sweeping.plan import iterate, plan
from orchestrator.sweeping.sweep_request import SweepRequest
from orchestrator.sweeping.work import SweepTask

COUNT = 400
REQUEST = SweepRequest("static", ("plant.m=1500:2500", "controller.b_3=log:1e-3:1e-1"), f"lhs:{COUNT}")


WORKERS = """
cluster = "distributed.LocalCluster"
workers = 2
options = { host = "127.0.0.1", threads_per_worker = 1, n_workers = 0, dashboard_address = ":0" }
"""


def rate(request, on, jobs, folder):
    """Variants per second, without the start of the workers."""
    planned, force = plan(request, SILENT), workforce(on, jobs)
    journal = str(folder) if force.is_here else None
    task = SweepTask(f"{on}{jobs}{folder.name}", "static", request.options, journal, planned.watched)
    engine = Engine(task, force, folder)
    with engine.working():
        results = engine.run(iterate(planned, set()))
        for _ in range(8 * force.workers):  # until all workers are at work
            next(results)
        began, count = time.perf_counter(), sum(1 for _ in results)
        return count / (time.perf_counter() - began)


@pytest.mark.parametrize(("on", "jobs"), [("processes", 1), ("processes", 2), ("threads", 1), ("threads", 2)])
@pytest.mark.parametrize("isolate", [(), ("plant",)], ids=["our own FMUs", "the plant in a process of its own"])
def test_variants_per_second(benchmark, built_fmus, tmp_path_factory, on, jobs, isolate):
    measure(benchmark, on, jobs, replace(REQUEST, options=Options(isolate=isolate)), tmp_path_factory)


def test_variants_per_second_of_a_cluster_of_two(benchmark, built_fmus, tmp_path, tmp_path_factory):
    (tmp_path / "workers.toml").write_text(WORKERS)
    measure(benchmark, str(tmp_path / "workers.toml"), None, REQUEST, tmp_path_factory)


def measure(benchmark, on, jobs, request, tmp_path_factory):
    rates = []

    def once():
        rates.append(rate(request, on, jobs, tmp_path_factory.mktemp("done")))

    benchmark.pedantic(once, rounds=3)
    benchmark.extra_info["variants per second"] = sorted(rates)[1]


def test_stepping_alone(benchmark, built_fmus):
    """All ticks of `static`, opened once: what no sweep can be faster than."""
    scenario = load("static")
    with Simulation(scenario.system, h=scenario.h, until=scenario.until) as simulation:

        def once():
            simulation.run()

        benchmark.pedantic(once, setup=simulation.reset, rounds=200)
