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
from tests.fmus.foreign import description2, description3, library, pack, scalar

G, E = 9.81, 0.7
START = {"initial": "exact"}
DISCRETE = 'variability="discrete" initial="exact" start="0"'


def ball2():
    variables = [
        scalar("h", 1, "output", of_start="1", **START),
        scalar("v", 2, "output", of_start="0", **START),
        scalar("der(h)", 3, "local", of_derivative="1"),
        scalar("der(v)", 4, "local", of_derivative="2"),
        scalar("g", 5, "parameter", variability="tunable", of_start="9.81"),
        scalar("e", 6, "parameter", variability="tunable", of_start="0.7"),
        scalar("bounces", 7, "output", variability="discrete", of_start="0", **START),
    ]
    outputs = [f'<Unknown index="{i}" dependencies=""/>' for i in (1, 2, 7)]
    return description2(
        variables,
        outputs,
        interface='<ModelExchange modelIdentifier="m" completedIntegratorStepNotNeeded="true"/>',
        guid="me",
        attributes='numberOfEventIndicators="1"',
        derivatives=['<Unknown index="3" dependencies="2"/>', '<Unknown index="4" dependencies="5"/>'],
    )


def ball3():
    variables = [
        '<Float64 name="h" valueReference="1" causality="output" initial="exact" start="1"/>',
        '<Float64 name="v" valueReference="2" causality="output" initial="exact" start="0"/>',
        '<Float64 name="der(h)" valueReference="3" derivative="1"/>',
        '<Float64 name="der(v)" valueReference="4" derivative="2"/>',
        '<Float64 name="g" valueReference="5" causality="parameter" variability="tunable" start="9.81"/>',
        '<Float64 name="e" valueReference="6" causality="parameter" variability="tunable" start="0.7"/>',
        f'<Float64 name="bounces" valueReference="7" causality="output" {DISCRETE}/>',
        '<Float64 name="z" valueReference="8"/>',
    ]
    structure = [f'<Output valueReference="{i}" dependencies=""/>' for i in (1, 2, 7)]
    structure += ['<ContinuousStateDerivative valueReference="3"/>', '<ContinuousStateDerivative valueReference="4"/>']
    structure += ['<EventIndicator valueReference="8"/>']
    return description3(variables, structure, interface='<ModelExchange modelIdentifier="m"/>', guid="me")


def stiff2():
    variables = [
        scalar("x1", 1, "output", of_start="2", of_nominal="10", **START),
        scalar("x2", 2, "output", of_start="1", **START),
        scalar("der(x1)", 3, "local", of_derivative="1"),
        scalar("der(x2)", 4, "local", of_derivative="2"),
        scalar("u", 5, "input", of_start="0"),
        scalar("y", 6, "output"),
    ]
    outputs = [f'<Unknown index="{i}" dependencies="{needs}"/>' for i, needs in ((1, ""), (2, ""), (6, "1 5"))]
    return description2(
        variables,
        outputs,
        interface='<ModelExchange modelIdentifier="m" completedIntegratorStepNotNeeded="true"/>',
        guid="me",
        derivatives=['<Unknown index="3"/>', '<Unknown index="4"/>'],
        initial=['<Unknown index="3"/>', '<Unknown index="4"/>', '<Unknown index="6"/>'],
    )


def stiff3():
    variables = [
        '<Float64 name="x1" valueReference="1" causality="output" initial="exact" start="2" nominal="10"/>',
        '<Float64 name="x2" valueReference="2" causality="output" initial="exact" start="1"/>',
        '<Float64 name="der(x1)" valueReference="3" derivative="1"/>',
        '<Float64 name="der(x2)" valueReference="4" derivative="2"/>',
        '<Float64 name="u" valueReference="5" causality="input" start="0"/>',
        '<Float64 name="y" valueReference="6" causality="output"/>',
    ]
    structure = ['<Output valueReference="1" dependencies=""/>', '<Output valueReference="2" dependencies=""/>']
    structure += ['<Output valueReference="6" dependencies="1 5"/>']
    structure += ['<ContinuousStateDerivative valueReference="3"/>', '<ContinuousStateDerivative valueReference="4"/>']
    structure += [f'<InitialUnknown valueReference="{i}"/>' for i in (3, 4, 6)]
    return description3(variables, structure, interface='<ModelExchange modelIdentifier="m"/>', guid="me")


CLOCKWORK = {
    1: ("x", "output", 0.0),
    5: ("openings", "output", 0.0),
    6: ("steps", "output", 0.0),
    7: ("end", "parameter", 1e9),
    8: ("iterations", "parameter", 0.0),
    12: ("limit", "parameter", 1e9),
}


def clockwork2():
    variables = [
        scalar("x", 1, "output", of_start="0", **START),
        scalar("der(x)", 2, "local", of_derivative="1"),
        scalar("gate", 4, "input", "Boolean", variability="discrete", of_start="false"),
        scalar("openings", 5, "output", variability="discrete", of_start="0", **START),
        scalar("steps", 6, "output", variability="discrete", of_start="0", **START),
        *(
            scalar(CLOCKWORK[i][0], i, "parameter", variability="tunable", of_start=str(CLOCKWORK[i][2]))
            for i in (7, 8, 12)
        ),
    ]
    outputs = ['<Unknown index="1" dependencies=""/>', '<Unknown index="4" dependencies="3"/>']
    outputs += ['<Unknown index="5" dependencies=""/>']
    interface = '<ModelExchange modelIdentifier="m"/>'
    return description2(variables, outputs, interface=interface, guid="me", derivatives=['<Unknown index="2"/>'])


def clockwork3():
    variables = [
        '<Float64 name="x" valueReference="1" causality="output" initial="exact" start="0"/>',
        '<Float64 name="der(x)" valueReference="2" derivative="1"/>',
        '<Boolean name="gate" valueReference="4" causality="input" start="false"/>',
        f'<Float64 name="openings" valueReference="5" causality="output" {DISCRETE}/>',
        f'<Float64 name="steps" valueReference="6" causality="output" {DISCRETE}/>',
    ]
    for reference in (7, 8, 12):
        name, _, start = CLOCKWORK[reference]
        kind = f'causality="parameter" variability="tunable" start="{start}"'
        variables.append(f'<Float64 name="{name}" valueReference="{reference}" {kind}/>')
    structure = ['<Output valueReference="1" dependencies=""/>', '<Output valueReference="5" dependencies="4"/>']
    structure += ['<Output valueReference="6" dependencies=""/>', '<ContinuousStateDerivative valueReference="2"/>']
    interface = '<ModelExchange modelIdentifier="m" needsCompletedIntegratorStep="true"/>'
    return description3(variables, structure, interface=interface, guid="me")


DESCRIPTIONS = {
    ("ball", 2): ball2,
    ("ball", 3): ball3,
    ("stiff", 2): stiff2,
    ("stiff", 3): stiff3,
    ("clockwork", 2): clockwork2,
    ("clockwork", 3): clockwork3,
}


@pytest.fixture(scope="session")
def models(tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    made = {}
    for (name, version), description in DESCRIPTIONS.items():
        where = folder / f"{name}{version}"
        binary = library(where, Version(version), f'#include "me{version}.c"', f'-DMODEL="{name}.h"')
        made[name, version] = pack(where / f"{name}.fmu", Version(version), description(), binary)
    return made


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
    both = ball2().replace("<ModelVariables>", '<CoSimulation modelIdentifier="m"/><ModelVariables>')
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
