"""Stepping by hand, rows, faults (`simulation_error.py`); `running_units.py`, `lifetime.py` and `whole_run.py`."""

from __future__ import annotations

import gc
from typing import final

import numpy as np
import pandas as pd
import pytest

from components.interfaces.block import Block, block
from components.interfaces.buses import VehicleState
from components.interfaces.problem import RequestError
from components.interfaces.quantity import quantity
from components.interfaces.record import combine
from components.interfaces.sockets import PLANT, PlantInputs, PlantOutputs, standard_wiring
from fmus.units.block_unit import BlockUnit
from fmus.units.unit import UnitError
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import InProcess, block_source
from orchestrator.system.system import System

WIRING = standard_wiring()


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


@final
@block(PLANT)
class Breaking(Block[PlantInputs, VehicleState, PlantOutputs]):
    """Plant whose position is not a number any more after some steps."""

    growth: float = quantity("m", "x grows by this per step", min=0)

    def start(self):
        return VehicleState(x=1.0, y=0.0, psi=0.0, v_x=10.0, v_y=0.0, r=0.0)

    def output(self, x, u):
        return PlantOutputs(state=x)

    def step(self, x, u, h):
        grown = combine(lambda value: value * self.growth, x)
        return VehicleState(x=grown.x, y=x.y, psi=x.psi, v_x=x.v_x, v_y=x.v_y, r=x.r)


@pytest.fixture
def closings(monkeypatch):
    """The names of the units that have been closed, in order."""
    closed: list[str] = []
    close = BlockUnit.close
    monkeypatch.setattr(BlockUnit, "close", lambda unit: (closed.append(unit.name), close(unit)))
    return closed


def with_plant(static, plant):
    return System({**static.system.units, "plant": plant}, WIRING)


def test_time_is_tick_times_step_and_never_a_running_sum(static):
    frame = simulate(static.system, h=0.1, until=11.3)
    assert frame["time"].tolist() == [k * 0.1 for k in range(114)]


def test_iteration_gives_every_instant(static):
    with Simulation(static.system, h=0.1, until=0.5) as simulation:
        ticks = [(tick.tick, tick.time, simulation.read("plant.state.x")) for tick in simulation]
    assert [k for k, _, _ in ticks] == list(range(6))
    assert [t for _, t, _ in ticks] == [k * 0.1 for k in range(6)]
    np.testing.assert_array_equal([x for _, _, x in ticks], simulation.frame()["plant.state.x"])


def test_by_hand_a_person_steps_reads_writes_goes_on_and_stops(static):
    with Simulation(static.system, h=0.1, until=11.3) as simulation:
        for _ in range(10):
            simulation.step()
        assert simulation.read("controller.path.x").shape == (15,)
        assert simulation.read("traffic.obstacles.valid").tolist() == [True] * 3 + [False] * 5
        straight = simulation.read("plant.state.r")
        simulation.write("plant.actuation.delta_f", 0.1)
        simulation.step()
        assert simulation.read("plant.state.r") == pytest.approx(straight, abs=1e-3) or simulation.tick == 10
        simulation.step()
        turned = simulation.read("plant.state.r")
        assert turned > straight + 0.1
        simulation.release("plant.actuation.delta_f")
        simulation.step()
        simulation.step()
        assert simulation.read("plant.state.r") < turned
    frame = simulation.frame()
    assert len(frame) == 14
    assert frame["time"].iloc[-1] == 13 * 0.1


def test_a_written_input_acts_from_the_next_step_and_is_seen_by_feedthrough(static):
    with Simulation(static.system, h=0.1, until=1.0) as simulation:
        simulation.step()
        simulation.write("plant.actuation.delta_f", 0.2)
        simulation.step()
        x, r = simulation.read("plant.state.v_x"), simulation.read("plant.state.r")
        v_y = simulation.read("plant.state.v_y")
        assert simulation.read("plant.tyre.alpha_f") == pytest.approx((v_y + 1.2 * r) / x - 0.2, rel=1e-12)


def test_what_a_written_input_received_stands_in_the_rows(static):
    with Simulation(static.system, h=0.1, until=1.0) as simulation:
        for tick in simulation:
            if tick.tick == 3:
                simulation.write("plant.actuation.delta_f", 0.2)
            if tick.tick == 6:
                simulation.release("plant.actuation.delta_f")
        frame = simulation.frame()
    received, asked = frame["plant.actuation.delta_f"], frame["controller.actuation.delta_f"]
    held = frame.index.isin([4, 5, 6])
    assert (received[held] == 0.2).all()
    assert (received[~held] == asked[~held]).all()
    alpha_f = (frame["plant.state.v_y"] + 1.2 * frame["plant.state.r"]) / frame["plant.state.v_x"] - received
    np.testing.assert_allclose(frame["plant.tyre.alpha_f"], alpha_f, atol=1e-14)
    assert "plant.actuation.T_r" not in frame


def test_a_row_holds_the_state_at_an_instant_and_the_actuation_computed_from_it(static):
    frame = simulate(static.system, h=0.1, until=5.0)
    s = frame.filter(like="plant.state.").rename(columns=lambda c: c.removeprefix("plant.state."))
    alpha_f = (s.v_y + 1.2 * s.r) / s.v_x - frame["controller.actuation.delta_f"]  # (3)
    np.testing.assert_allclose(frame["plant.tyre.alpha_f"], alpha_f, rtol=0, atol=1e-14)


def test_without_a_with_statement_the_first_step_opens_and_the_stop_time_closes(static, closings):
    simulation = Simulation(static.system, h=0.1, until=0.3)
    assert closings == []
    x = [simulation.step() and simulation.read("plant.state.x") for _ in range(4)]  # as in the cells of a notebook
    assert closings == ["plant", "traffic", "controller"]
    assert simulation.read("plant.state.x") == x[-1]
    with Simulation(static.system, h=0.1, until=0.3) as same:
        same.run()
    pd.testing.assert_frame_equal(simulation.frame(), same.frame(), check_exact=True)
    with pytest.raises(StopIteration):
        simulation.step()
    found = r"simulation: found closed at 0.3 s; its rows stay; valid: one that is open. Make another Simulation"
    with pytest.raises(RequestError, match=found):
        simulation.write("plant.actuation.delta_f", 0.1)
    with pytest.raises(RequestError, match=found):
        simulation.__enter__()


def test_a_value_can_be_read_and_written_before_the_first_step(static, closings):
    simulation = Simulation(static.system, h=0.1, until=0.3)
    assert simulation.read("plant.state.v_x") == 10.0
    simulation.write("plant.actuation.delta_f", 0.1)
    simulation.step()
    assert simulation.frame()["plant.actuation.delta_f"].tolist() == [0.1]
    simulation.close()
    simulation.close()
    assert closings == ["plant", "traffic", "controller"]
    with pytest.raises(RequestError, match="simulation: found closed at 0 s"):
        simulation.step()


def test_a_simulation_that_is_forgotten_closes_its_units(static, closings):
    simulation = Simulation(static.system, h=0.1, until=0.3)
    simulation.step()
    assert closings == []
    del simulation
    gc.collect()
    assert closings == ["plant", "traffic", "controller"]


def test_going_on_after_the_end_is_told(static):
    with Simulation(static.system, h=0.1, until=0.1) as simulation:
        simulation.run()
        with pytest.raises(StopIteration):
            simulation.step()


@pytest.mark.parametrize(
    ("h", "until", "text"),
    [
        (0.0, 1.0, "step: found 0 s; valid: a positive number of seconds"),
        (float("nan"), 1.0, "step: found nan s"),
        (0.1, -1.0, "stop time: found -1 s; valid: a number of seconds, 0 or more"),
        (0.1, 0.25, "stop time: found 0.25 s; valid: a whole number of steps of 0.1 s. Try 0.2 s."),
    ],
)
def test_a_wrong_experiment_is_refused(static, h, until, text):
    with pytest.raises(RequestError) as error:
        Simulation(static.system, h=h, until=until)
    assert str(error.value).startswith(text)


def test_unknown_signals_and_wrong_values_are_refused(static):
    with Simulation(static.system, h=0.1, until=1.0) as simulation:
        simulation.step()
        with pytest.raises(RequestError, match=r"plant.state.vx: found no such output.*Did you mean `plant.state.v_x`"):
            simulation.read("plant.state.vx")
        with pytest.raises(
            RequestError,
            match="plant.state.x: found an output, which its unit computes",
        ):
            simulation.write("plant.state.x", 1.0)
        with pytest.raises(RequestError, match=r"plant.actuation.T_r: found nan; valid: finite number \[N.m\]"):
            simulation.write("plant.actuation.T_r", float("nan"))


def test_a_value_that_is_not_finite_ends_the_run_and_keeps_the_rows(static):
    broken = with_plant(static, block_source(Breaking(growth=1e300)))
    with Simulation(broken, h=0.1, until=1.0) as simulation:
        with pytest.raises(SimulationError) as error:
            simulation.run()
        frame = simulation.frame()
    assert str(error.value) == (
        "tick 2 (t = 0.2 s), unit `plant`: the signal `plant.state.x` is inf, which `traffic.ego.x`, `controller.ego.x`"
        " would receive; --allow-nonfinite 'plant.state.x' lets it pass"
    )
    assert frame["plant.state.x"].tolist() == [1.0, 1e300, np.inf]


def test_a_unit_that_fails_to_start_is_a_fault_at_time_zero(static, monkeypatch):
    def refuse(self, *_):
        raise UnitError("plant", "the initialization failed", ["m is negative"])

    monkeypatch.setattr("fmus.units.block_unit.BlockUnit.enter_initialization", refuse)
    with pytest.raises(SimulationError) as error, Simulation(static.system, h=0.1, until=1.0):
        pass
    assert str(error.value) == "tick 0 (t = 0 s), unit `plant`: the initialization failed: m is negative"


def test_two_runs_in_one_process_do_not_share_anything(static):
    with (
        Simulation(static.system, h=0.1, until=3.0) as first,
        Simulation(static.system, h=0.1, until=3.0) as second,
    ):
        for _ in range(31):
            first.step()
            second.step()
    assert first.frame().equals(second.frame())


def test_blocks_without_state_or_outputs_of_a_type_run():
    idle = prepare("idle", Options(mode="blocks"))
    frame = simulate(idle.system, h=idle.h, until=idle.until)
    assert frame["plant.state.x"].eq(0).all()
    assert not frame["traffic.obstacles.valid[1]"].any()
    assert isinstance(idle.system.units["plant"], InProcess)
