"""An FMI 3.0 FMU with a clock of every kind, run with Event Mode by our master."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.version import Version
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import C, description3, library, pack

KINDS = ("constant", "fixed", "tunable", "countdown", "triggered", "early")
CLOCKS = {
    "constant": 'causality="input" intervalVariability="constant" intervalDecimal="0.25" shiftDecimal="0.05"',
    "fixed": 'causality="input" intervalVariability="fixed"',
    "tunable": 'causality="input" intervalVariability="tunable" intervalDecimal="0.3"',
    "countdown": 'causality="input" intervalVariability="countdown"',
    "triggered": 'causality="input" intervalVariability="triggered"',
    "beat": 'causality="output" intervalVariability="triggered"',
}


@pytest.fixture(scope="module")
def metronome(tmp_path_factory):
    return made(tmp_path_factory.mktemp("metronome"), CLOCKS)


def made(folder, clocks):
    """An FMU with these clocks."""
    variables = [
        '<Float64 name="u" valueReference="1" causality="input" start="0"/>',
        '<Float64 name="end" valueReference="2" causality="parameter" variability="fixed" start="0"/>',
        '<Float64 name="sampled" valueReference="40" causality="output" variability="discrete" clocks="11"/>',
        '<Float64 name="w" valueReference="41" causality="input" variability="discrete" clocks="11" start="0"/>',
    ]
    for i, (name, attributes) in enumerate(clocks.items()):
        variables.append(f'<Clock name="{name}" valueReference="{10 + i}" {attributes}/>')
    outputs = {40: ' dependencies="1 41"'}
    for i, name in enumerate(KINDS):
        variables.append(f'<Int32 name="n.{name}" valueReference="{20 + i}" causality="output"/>')
        variables.append(
            f'<Float64 name="last.{name}" valueReference="{30 + i}" causality="output" variability="discrete"/>'
        )
        outputs |= {20 + i: ' dependencies=""', 30 + i: ' dependencies=""'}
    outputs[15] = ' dependencies=""'
    structure = [f'<Output valueReference="{vr}"{told}/>' for vr, told in outputs.items()]
    interface = '<CoSimulation modelIdentifier="m" hasEventMode="true" canReturnEarlyAfterIntermediateUpdate="true"/>'
    binary = library(folder, Version.FMI3, (C / "clocked.c").read_text())
    return pack(folder / "metronome.fmu", Version.FMI3, description3(variables, structure, interface=interface), binary)


def alone(path, **parameters):
    return System({"m": Fmu(path, parameters)}, {}, held={"m.u": 2.0, "m.w": 0.5})


def ticks(first, interval, t):
    """How many of the instants first, first + interval, ... are not after t."""
    return max(0, math.floor((t - first) / interval + 1e-9) + 1)


def test_periodic_clocks_tick_at_their_own_instants(metronome):
    frame = simulate(alone(metronome), h=0.1, until=1.2, algorithm="clocked")
    for t, constant, fixed, tunable in zip(
        frame["time"], frame["m.n.constant"], frame["m.n.fixed"], frame["m.n.tunable"], strict=True
    ):
        assert constant == ticks(0.05, 0.25, t)
        assert fixed == ticks(0.0, 0.1, t)  # its interval is the macro step, its shift ours to choose
        # 0.1 (its shift), 0.4, then every 0.2 s
        assert tunable == ticks(0.1, 0.3, min(t, 0.45)) + ticks(0.6, 0.2, t)
    assert frame["m.last.constant"].iloc[-1] == pytest.approx(1.05, abs=1e-12)


def test_a_changing_clock_says_at_each_tick_when_the_next_one_is(tmp_path):
    """It has no shift: its first tick is one interval after the start, at 0.3 s, then 0.6, and every 0.2 s."""
    changing = 'causality="input" intervalVariability="changing"'
    frame = simulate(alone(made(tmp_path, CLOCKS | {"tunable": changing})), h=0.1, until=1.2, algorithm="clocked")
    instants = (0.3, 0.6, 0.8, 1.0, 1.2)
    assert frame["m.n.tunable"].tolist() == [sum(s < t + 1e-9 for s in instants) for t in frame["time"]]
    assert frame["m.last.tunable"].iloc[-1] == pytest.approx(1.2, abs=1e-12)


def test_an_early_return_is_handled_where_it_happens_and_starts_a_countdown(metronome):
    frame = simulate(alone(metronome), h=0.1, until=1.2, algorithm="clocked")
    early, countdown = (frame[f"m.n.{name}"].tolist() for name in ("early", "countdown"))
    assert early == [0] * 4 + [1] * 4 + [2] * 5
    assert countdown == [0] * 5 + [1] * 4 + [2] * 4
    assert frame["m.last.countdown"].iloc[-1] == pytest.approx(0.87, abs=1e-9)


@pytest.mark.parametrize("h", [0.05, 0.1, 0.3])
def test_the_macro_step_does_not_move_the_ticks(metronome, h):
    frame = simulate(alone(metronome), h=h, until=0.9, algorithm="clocked")
    assert frame["m.n.constant"].iloc[-1] == 4
    assert frame["m.last.constant"].iloc[-1] == pytest.approx(0.8, abs=1e-12)
    assert frame["m.n.early"].iloc[-1] == 2


def test_clocked_variables_are_set_and_read_while_their_clock_ticks(metronome):
    frame = simulate(alone(metronome), h=0.1, until=0.5, algorithm="clocked")
    assert frame["m.sampled"].tolist() == [2.5] * 6


def test_a_tick_is_handed_on_at_the_same_instant_or_the_next_communication_point(metronome):
    two = {"a": Fmu(metronome), "b": Fmu(metronome)}
    held = {f"{unit}.{name}": 0.0 for unit in two for name in ("u", "w")}
    system = System(two, {"b.triggered": "a.beat"}, held=held)
    with Simulation(system, h=0.1, until=1.0, algorithm="clocked") as simulation:
        assert simulation.schedule.order.index("a") < simulation.schedule.order.index("b")
        simulation.run()
        frame = simulation.frame()
    # beats of a at 0.05 (seen at 0.1), 0.3, 0.55 (seen at 0.6), 0.8
    assert frame["b.n.triggered"].tolist() == [0, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4]
    assert frame["b.last.triggered"].tolist() == pytest.approx([0, 0.1, 0.1, 0.3, 0.3, 0.3, 0.6, 0.6, 0.8, 0.8, 0.8])
    assert set(frame["a.n.triggered"]) == {0}


def test_what_is_no_output_clock_makes_nothing_tick(metronome):
    two = {"a": Fmu(metronome), "b": Fmu(metronome)}
    held = {f"{unit}.{name}": 0.0 for unit in two for name in ("u", "w")}
    with pytest.raises(RequestError) as error:
        System(two, {"b.triggered": "a.n.early"}, held=held)
    assert str(error.value) == (
        "a.n.early -> b.triggered: found `a.n.early`, which is no output clock; valid: an output clock"
    )


def test_an_fmu_that_asks_for_the_end_gets_it(metronome):
    with Simulation(alone(metronome, end=1.0), h=0.1, until=1.0, algorithm="clocked") as simulation:
        simulation.run()
        assert simulation.frame()["time"].iloc[-1] == 0.5
    assert simulation.remarks == [
        "`m` asked for the end of the run at 0.5 s: the run ends there, and its last row has its values"
    ]


def test_as_a_part_of_the_macro_step(metronome):
    """Two metronomes, one with steps of half a macro step: its clocks tick as before."""
    system = System({"m": Fmu(metronome)}, {}, held={"m.u": 0.0, "m.w": 0.0}, steps={"m": Fraction(1, 2)})
    frame = simulate(system, h=0.2, until=1.2, algorithm="clocked")
    assert frame["m.n.constant"].tolist() == [ticks(0.05, 0.25, t) for t in frame["time"]]
