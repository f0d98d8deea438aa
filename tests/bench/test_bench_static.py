"""The static scenario: the controller's step, the whole step, and the command as a person waits for it."""

from __future__ import annotations

import itertools
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest

from components.interfaces.quantity import DTYPES
from fmus import fmu_unit, open_fmu
from fmus.toolchain.version import WRITTEN_VERSIONS
from fmus.units.unit import widths
from orchestrator import Options, Simulation, load

STEPS = 1000


@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=lambda v: f"fmi{v}")
def test_controller_step(benchmark, built_fmus, version):
    """Path, corridor and solve of `mpc`, at states of the static run in the middle of the lane change."""
    made = load("static", Options(mode=version))
    with Simulation(made.system, h=made.h, until=3.0) as simulation:
        simulation.run()
        driven = simulation._table.inputs("controller")
        for gather in simulation._table.gathers("controller"):
            gather()
        columns = {kind: column.copy() for kind, column in driven.items()}
    unit = fmu_unit("controller", open_fmu(built_fmus / f"fmi{version}" / "mpc.fmu"))
    unit.bind(columns, {k: np.zeros(n, DTYPES[k]) for k, n in widths(unit.interface.outputs).items()})
    unit.enter_initialization(made.system.units["controller"].parameters)
    unit.exit_initialization()
    for setter in unit.setters():
        setter()

    clock = itertools.count()

    def step():
        for k in itertools.islice(clock, STEPS):
            assert not unit.step(0.1 * k, 0.1), unit.messages

    benchmark.extra_info["steps per round"] = STEPS
    benchmark(step)
    unit.close()


@pytest.mark.parametrize("mode", ["blocks", *WRITTEN_VERSIONS], ids=str)
def test_stepping_the_static_scenario(benchmark, built_fmus, mode):
    made = load("static", Options(mode=mode))

    def fresh():
        simulation = Simulation(made.system, h=made.h, until=made.until)
        simulation.__enter__()
        return (simulation,), {}

    def run(simulation):
        simulation.run()
        simulation.close()

    benchmark.extra_info["steps per round"] = 114
    benchmark.pedantic(run, setup=fresh, rounds=10)


@pytest.mark.parametrize("threads", [1, 2])
def test_two_simulations_in_as_many_threads(benchmark, built_fmus, threads):
    """Two runs of 5000 steps, one after the other or side by side: C steps them without Python's lock."""
    made = load("static", Options(mode=WRITTEN_VERSIONS[0]))

    def fresh():
        opened = [Simulation(made.system, h=0.1, until=500.0) for _ in range(2)]
        return ([simulation.__enter__() for simulation in opened],), {}

    def run(simulations):
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(Simulation.run, simulations))
        for simulation in simulations:
            simulation.close()

    benchmark.pedantic(run, setup=fresh, rounds=10)


@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=lambda v: f"fmi{v}")
@pytest.mark.parametrize("what", ["reset", "save and restore"])
def test_going_back(benchmark, built_fmus, version, what):
    """To the start with another mass, or to the present tick."""
    made = load("static", Options(mode=version))
    with Simulation(made.system, h=made.h, until=made.until) as simulation:
        for _ in range(40):
            simulation.step()
        if what == "reset":
            benchmark(simulation.reset, {"plant.m": 1700.0})
        else:
            benchmark(lambda: simulation.restore(simulation.save()))


def test_the_command(benchmark, built_fmus, in_tmp_path):
    command = [sys.executable, "-m", "orchestrator.command.main", "run", "static", "--out", "run"]
    benchmark.pedantic(partial(subprocess.run, command, check=True, capture_output=True), rounds=5, warmup_rounds=1)
