"""What 1000 units with 10 000 connections take, beside a tenth of them: ten times as long, or less."""

from __future__ import annotations

import pytest

from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.stepping.master import Simulation
from tests.orchestrator.large import of_blocks, ssp_of_units

SIZES = pytest.mark.parametrize("units", [100, 1000])
STEPS = 100


@SIZES
def test_a_system_is_checked(benchmark, units):
    benchmark.pedantic(of_blocks, [units], rounds=5)


@SIZES
def test_a_simulation_is_prepared(benchmark, units):
    made = of_blocks(units)
    benchmark.pedantic(lambda: Simulation(made, h=0.1, until=0.1 * STEPS), rounds=5)


@SIZES
def test_its_units_step(benchmark, units):
    def opened():
        simulation = Simulation(of_blocks(units), h=0.1, until=0.1 * STEPS)
        simulation.__enter__()
        return (simulation,), {}

    benchmark.extra_info["steps per round"] = STEPS + 1
    benchmark.pedantic(Simulation.run, setup=opened, rounds=5)


@SIZES
def test_an_ssp_is_read(benchmark, units, tmp_path):
    path = ssp_of_units(tmp_path, units)
    benchmark.pedantic(lambda: load(path, Options()), rounds=3)
