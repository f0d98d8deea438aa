"""What a process of its own adds to the step of an FMU: inputs set, one step, outputs read.

Both are timed in the same run; the step in this process is what the other one is compared with.
"""

from __future__ import annotations

import itertools

import pytest

from components.interfaces.quantity import zeros
from fmus.reading.opening import open_fmu
from fmus.units.isolated_unit import IsolatedUnit
from fmus.units.make import fmu_unit
from fmus.units.unit import widths

H = 0.001
BUDGET = {"added by a process, per step": "15 us"}


@pytest.fixture(params=[fmu_unit, IsolatedUnit], ids=["in this process", "in its own process"])
def unit(request, built_fmus):
    made = request.param("plant", open_fmu(built_fmus / "fmi3" / "stationary.fmu"))
    interface = made.interface
    made.bind(*({k: zeros(k, n) for k, n in widths(v).items()} for v in (interface.inputs, interface.outputs)))
    made.enter_initialization({})
    made.exit_initialization()
    yield made
    made.close()


@pytest.mark.benchmark(group="one step of one FMU")
def test_one_step(benchmark, unit):
    calls = [*unit.setters(), *unit.getters()]
    first, last, ticks = calls[: len(unit.setters())], calls[len(unit.setters()) :], itertools.count()

    def step():
        for call in first:
            call()
        status = unit.step(next(ticks) * H, H)
        for call in last:
            call()
        return status

    benchmark.extra_info["budget"] = BUDGET
    assert not benchmark.pedantic(step, rounds=20_000, warmup_rounds=500)


@pytest.mark.benchmark(group="the start and the end of one FMU")
@pytest.mark.parametrize("make", [fmu_unit, IsolatedUnit], ids=["in this process", "in its own process"])
def test_opening(benchmark, make, built_fmus):
    archive = open_fmu(built_fmus / "fmi3" / "stationary.fmu")
    benchmark.pedantic(lambda: make("plant", archive).close(), rounds=5)
