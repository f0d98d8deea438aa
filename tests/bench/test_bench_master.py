"""What the master adds to each macro step: three trivial FMUs, 10 connections, as in the budgets of the project."""

from __future__ import annotations

import sys
from typing import final

import pytest

from components.interfaces.block import Block, block
from components.interfaces.maths import Array, vector
from components.interfaces.quantity import quantity
from components.interfaces.record import record
from components.interfaces.socket import Socket
from fmus.export.build import build
from fmus.toolchain.stepper_library import stepper_library
from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator.ssp import writer as ssp_writer
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import Scenario
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.closed_loop.peers import load_tbb

STEPS = 2000


@record
class Two:
    """Two numbers."""

    a: float = quantity("1", "a number")
    b: float = quantity("1", "a number")


@record
class Four:
    """Four numbers."""

    a: float = quantity("1", "a number")
    b: float = quantity("1", "a number")
    c: float = quantity("1", "a number")
    d: float = quantity("1", "a number")


@record
class TwoIn:
    """A bus of two."""

    u: Two


@record
class FourIn:
    """A bus of four."""

    u: Four


@record
class TwoOut:
    """A bus of two."""

    y: Two


@record
class Ten:
    """Ten numbers that nobody reads."""

    values: Array = quantity("1", "numbers", shape=(10,))


@record
class FourOut:
    """A bus of four, and ten numbers to record."""

    y: Four
    more: Ten


@final
@block(Socket(name="any", inputs={"u": Two}, outputs={}, optional={}))
class TrivialPlant(Block[TwoIn, Four, FourOut]):
    """Four states that follow two inputs."""

    def start(self):
        return Four(a=0.0, b=0.0, c=0.0, d=0.0)

    def output(self, x, u):
        return FourOut(y=x, more=Ten(values=vector([x.a] * 10)))

    def step(self, x, u, h):
        return Four(a=x.a + h * u.u.a, b=x.b + h * u.u.b, c=x.a, d=x.b)


@final
@block(Socket(name="any", inputs={"u": Four}, outputs={}, optional={}))
class TrivialTraffic(Block[FourIn, Four, FourOut]):
    """Four states that follow four inputs."""

    def start(self):
        return Four(a=0.0, b=0.0, c=0.0, d=0.0)

    def output(self, x, u):
        return FourOut(y=x, more=Ten(values=vector([x.a] * 10)))

    def step(self, x, u, h):
        return Four(a=u.u.a, b=u.u.b, c=u.u.c, d=u.u.d)


@final
@block(Socket(name="any", inputs={"u": Four}, outputs={}, optional={}))
class TrivialController(Block[FourIn, Two, TwoOut]):
    """Two outputs from four inputs, one step late."""

    def start(self):
        return Two(a=0.0, b=0.0)

    def output(self, x, u):
        return TwoOut(y=x)

    def step(self, x, u, h):
        return Two(a=-u.u.a, b=-u.u.b)


@pytest.fixture(scope="module", params=WRITTEN_VERSIONS, ids=lambda v: f"fmi{v}")
def trivial(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    kinds = {"plant": TrivialPlant, "traffic": TrivialTraffic, "controller": TrivialController}
    units = {name: Fmu(build(kind, request.param, {}, folder).path) for name, kind in kinds.items()}
    wiring = {"plant.u": "controller.y", "traffic.u": "plant.y", "controller.u": "traffic.y"}
    system = System(units, wiring)
    assert len(system.connections) == 10
    return system


@pytest.fixture(params=[True, False], ids=["native", "python"])
def native(request):
    if request.param and stepper_library().library is None:
        pytest.skip("there is no compiler")
    return request.param


@pytest.mark.parametrize("recorded", [0, 30])
def test_macro_steps(benchmark, trivial, native, recorded):
    """One round is a run of `STEPS` steps of units that are open, with as many signals recorded."""

    def fresh():
        record = {"*": 1} if recorded else {"*": 0}
        simulation = Simulation(trivial, h=0.1, until=0.1 * STEPS, record=record, native=native)
        simulation.__enter__()
        simulation.step()
        assert len(simulation.log.at_every_tick) == recorded
        opened.append(simulation)
        return (simulation,), {}

    opened = []
    benchmark.extra_info["steps per round"] = STEPS
    benchmark.pedantic(Simulation.run, setup=fresh, rounds=20)
    for simulation in opened:
        simulation.close()


@pytest.mark.skipif(sys.platform != "linux", reason="Ecos is installed on Linux only")
def test_macro_steps_of_ecos(benchmark, trivial, tmp_path):
    """The same three files in another master, which does all steps in one call."""
    load_tbb()
    from ecospy import EcosSimulation  # noqa: PLC0415

    ssp_writer.write(
        Scenario("trivial", "", trivial, scene=None, h=0.1, until=1.0, sources={}), tmp_path / "trivial.ssp"
    )
    with EcosSimulation(ssp_path=str(tmp_path / "trivial.ssp"), step_size=0.1) as simulation:
        assert simulation.init(parameter_set="trivial")
        benchmark.extra_info["steps per round"] = STEPS
        benchmark.pedantic(simulation.step, args=(STEPS,), rounds=20)
