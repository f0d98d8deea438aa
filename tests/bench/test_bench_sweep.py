"""Variants of `static` per second: one worker, two, and a Dask cluster, against stepping alone.

Run by `uv run pytest tests/bench/test_bench_sweep.py --benchmark-only --benchmark-json FILE`; the file has the rates.
"""

from __future__ import annotations

import time

import pytest

from components.interfaces.progress import SILENT
from orchestrator import Simulation, load
from orchestrator.sweeping.engine import Engine, workforce
from orchestrator.sweeping.plan import iterate, plan
from orchestrator.sweeping.sweep_request import SweepRequest
from orchestrator.sweeping.work import SweepTask

COUNT = 400
REQUEST = SweepRequest("static", ("plant.m=1500:2500", "controller.b_3=log:1e-3:1e-1"), f"lhs:{COUNT}")


@pytest.fixture(scope="module")
def planned(built_fmus):
    return plan(REQUEST, SILENT)


def rate(planned, on, jobs, folder):
    """Variants per second, without the start of the workers."""
    force = workforce(on, jobs)
    task = SweepTask(f"{on}{jobs}{folder.name}", "static", REQUEST.options, str(folder) if force.is_here else None)
    engine = Engine(task, force, folder)
    with engine.working():
        results = engine.run(iterate(planned, set()))
        for _ in range(8 * force.workers):  # until all workers are at work
            next(results)
        began, count = time.perf_counter(), sum(1 for _ in results)
        return count / (time.perf_counter() - began)


@pytest.mark.parametrize(("on", "jobs"), [("processes", 1), ("processes", 2), ("threads", 1), ("threads", 2)])
def test_variants_per_second(benchmark, planned, tmp_path_factory, on, jobs):
    rates = []

    def once():
        rates.append(rate(planned, on, jobs, tmp_path_factory.mktemp("done")))

    benchmark.pedantic(once, rounds=3)
    benchmark.extra_info["variants per second"] = sorted(rates)[1]


def test_stepping_alone(benchmark, built_fmus):
    """All ticks of `static`, opened once: what no sweep can be faster than."""
    scenario = load("static")
    with Simulation(scenario.system, h=scenario.h, until=scenario.until) as simulation:

        def once():
            simulation.run()

        benchmark.pedantic(once, setup=simulation.reset, rounds=200)
