"""Model Exchange FMUs as units, against analytic solutions and against FMPy's own simulation of the same files."""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu

from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from fmus.units import model_exchange
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import pack
from tests.fmus.model_exchange_models import DESCRIPTIONS, built_models

G, E = 9.81, 0.7


@pytest.fixture(scope="session")
def models():
    return built_models()


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def version(request):
    return request.param


def alone(path, parameters=None, held=None):
    return System({"m": Fmu(path, parameters or {}, in_process=True)}, {}, held=held or {})


def height(t):
    """Height and speed of a ball that falls from 1 m, and how often it has bounced."""
    began, speed, bounces = 0.0, 0.0, 0
    h = 1.0
    while True:
        lands = (speed + math.sqrt(speed**2 + 2 * G * h)) / G
        if t < began + lands:
            s = t - began
            return h + speed * s - G * s**2 / 2, speed - G * s, bounces
        speed, began, h, bounces = -E * (speed - G * lands), began + lands, 0.0, bounces + 1


def test_the_tolerances_and_feedthrough_are_those_of_the_description(models, version):
    archive = open_fmu(models["stiff", version])
    assert archive.is_model_exchange
    assert archive.interface.output_after_set
    assert archive.interface.feedthrough.tolist() == [[False], [False], [True]]
    assert archive.remarks == ()


def test_a_bouncing_ball_bounces_when_it_should(models, version):
    rows = simulate(alone(models["ball", version]), h=0.05, until=2.3)
    truth = np.array([height(t) for t in rows["time"]])
    assert rows["m.h"].to_numpy() == pytest.approx(truth[:, 0], abs=1e-6)
    assert rows["m.v"].to_numpy() == pytest.approx(truth[:, 1], abs=1e-6)
    assert rows["m.bounces"].tolist() == truth[:, 2].tolist()
    assert rows["m.bounces"].iloc[-1] == 6


def test_events_do_not_depend_on_the_macro_step(models, version):
    coarse = simulate(alone(models["ball", version]), h=0.5, until=2.0)
    fine = simulate(alone(models["ball", version]), h=0.01, until=2.0)
    assert coarse["m.h"].to_numpy() == pytest.approx(fine["m.h"].to_numpy()[::50], abs=1e-7)


def test_events_that_come_ever_faster_end_the_run_with_a_message(models, version, monkeypatch):
    monkeypatch.setattr(model_exchange, "MOST_EVENTS", 20)
    with Simulation(alone(models["ball", version]), h=0.1, until=3.0) as simulation:
        with pytest.raises(SimulationError) as error:
            simulation.run()
        assert len(simulation.frame()) == 26
    assert "unit `m`: more than 20 events from 2.5 s to 2.55" in str(error.value)
    assert str(error.value).endswith(": they may never end")


def test_a_stiff_system_is_as_its_solution(models, version):
    rows = simulate(alone(models["stiff", version], held={"m.u": 0.0}), h=0.1, until=2.0)
    t = rows["time"].to_numpy()
    assert rows["m.x2"].to_numpy() == pytest.approx(np.exp(-t), abs=1e-7)
    assert rows["m.x1"].to_numpy() == pytest.approx(np.exp(-t) + np.exp(-1000 * t), abs=1e-6)


def test_inputs_are_held_and_outputs_follow_them_at_once(models, version):
    with Simulation(alone(models["stiff", version], held={"m.u": 1.0}), h=0.1, until=1.0) as simulation:
        for tick in simulation:
            if tick.tick == 4:
                simulation.write("m.u", -1.0)
        rows = simulation.frame()
    t = rows["time"].to_numpy()
    up, down = t <= 0.45, t > 0.45
    x2 = np.where(up, 1.0, -1 + 2 * np.exp(-(t - 0.5)))  # what is written after a tick acts from the next one on
    assert rows["m.x2"].to_numpy() == pytest.approx(x2, abs=1e-7)
    u = np.where(down, -1.0, 1.0)
    assert rows["m.y"].to_numpy() - rows["m.x1"].to_numpy() == pytest.approx(2 * u, abs=1e-12)


def test_two_units_exchange_their_values_without_delay(models, version):
    units = {name: Fmu(models["stiff", version]) for name in ("a", "b")}
    rows = simulate(System(units, {"b.u": "a.y"}, held={"a.u": 0.5}), h=0.1, until=0.5)
    assert (rows["b.y"] - rows["b.x1"]).to_numpy() == pytest.approx(2 * rows["a.y"].to_numpy(), abs=1e-12)


def test_runs_are_as_fmpys(models, version):
    until, h = 2.0, 0.1
    own = simulate(alone(models["ball", version]), h=h, until=until)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = simulate_fmu(
            str(models["ball", version]),
            stop_time=until,
            output_interval=h,
            relative_tolerance=1e-9,
            record_events=False,
            output=["h", "v", "bounces"],
        )
    assert own["m.h"].to_numpy() == pytest.approx(theirs["h"], abs=1e-6)
    assert own["m.bounces"].tolist() == theirs["bounces"].tolist()


def test_time_events_happen_when_they_are_due(models, version):
    rows = simulate(alone(models["clockwork", version], held={"m.gate": False}), h=0.1, until=1.0)
    t = rows["time"].to_numpy()
    x = np.where(t < 0.25, t, np.where(t < 0.75, 0.25 + 2 * (t - 0.25), 1.25 + 4 * (t - 0.75)))
    assert rows["m.x"].to_numpy() == pytest.approx(x, abs=1e-9)


def test_completed_steps_are_told_one_by_one(models, version):
    rows = simulate(alone(models["clockwork", version], held={"m.gate": False}), h=0.1, until=1.0)
    assert (rows["m.steps"].diff().iloc[1:] >= 1).all()
    assert rows["m.steps"].iloc[-1] > 15


def test_discrete_inputs_are_set_in_event_mode_and_events_iterate(models, version):
    system = alone(models["clockwork", version], {"iterations": 3.0}, {"m.gate": False})
    with Simulation(system, h=0.1, until=0.5) as simulation:
        for tick in simulation:
            if tick.tick in (1, 3):
                simulation.write("m.gate", True)  # noqa: FBT003 - the value of the input
            if tick.tick == 2:
                simulation.write("m.gate", False)  # noqa: FBT003
        assert simulation.frame()["m.openings"].tolist() == [0, 0, 1, 1, 2, 2]


def test_an_event_that_does_not_settle_ends_the_run(models, version):
    system = alone(models["clockwork", version], {"iterations": 1e6}, {"m.gate": False})
    with pytest.raises(SimulationError) as error:
        simulate(system, h=0.1, until=0.5)
    assert str(error.value) == ("tick 0 (t = 0 s), unit `m`: the event at 0 s does not settle in 1000 iterations")


def test_an_fmu_that_ends_the_simulation_is_told(models, version):
    system = alone(models["clockwork", version], {"end": 0.33}, {"m.gate": False})
    with Simulation(system, h=0.1, until=0.5) as simulation:
        simulation.run()
        assert simulation.columns()["time"].tolist() == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.33], abs=1e-8)
    assert str(simulation.ended) == "`m` asked for the end of the run at 0.33 s"


def test_derivatives_that_fail_end_the_run_with_all_rows(models, version):
    system = alone(models["clockwork", version], {"limit": 0.15}, {"m.gate": False})
    with Simulation(system, h=0.1, until=0.5) as simulation:
        with pytest.raises(SimulationError) as error:
            simulation.run()
        assert len(simulation.frame()) == 2
    text = str(error.value)
    assert text.startswith("tick 1 (t = 0.1 s), unit `m`: CVODE cannot go on at 0.1")
    assert text.endswith("failed with status 3 (error).)")


def test_where_an_fmu_offers_both_co_simulation_is_taken(models, tmp_path):
    both = DESCRIPTIONS["ball", 2]().replace("<ModelVariables>", '<CoSimulation modelIdentifier="m"/><ModelVariables>')
    path = pack(tmp_path / "both.fmu", Version.FMI2, both, models["ball", 2])
    archive = open_fmu(path)
    assert (archive.is_model_exchange, archive.interface.output_after_set) == (False, False)


def test_many_runs_leave_no_memory_behind(models, version):
    def used():
        return int(Path("/proc/self/statm").read_text("ascii").split()[1])

    def once():
        simulate(alone(models["stiff", version], held={"m.u": 0.0}), h=0.1, until=0.1)

    for _ in range(15):
        once()
    before = used()
    for _ in range(30):
        once()
    assert used() - before < 400
