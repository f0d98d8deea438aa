"""The life cycle of Co-Simulation FMUs: what they are told, in which order they are called, and how they end."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.version import Version
from fmus.units.co_simulation import CoSimulationUnit
from fmus.units.make import fmu_unit
from orchestrator import Fmu, Simulation, SimulationError, System
from tests.fmus.foreign import description2, description3, kept_folder, library, pack, scalar

VARIABLES2 = [
    scalar("y", 0, "output"),
    scalar("u", 1, "input", of_start="4"),
    scalar("k", 2, "parameter", variability="fixed", of_start="1"),
    *(scalar(name, 3 + i, "output") for i, name in enumerate(("tolerance", "start", "stop"))),
]
OUTPUTS2 = [f'<Unknown index="{i}" dependencies=""/>' for i in (1, 4, 5, 6)]
NAMES3 = ("y", "tolerance", "start", "stop", "n")
VARIABLES3 = [f'<Float64 name="{n}" valueReference="{i}" causality="output"/>' for i, n in enumerate(NAMES3, 1)]
OUTPUTS3 = [f'<Output valueReference="{i}" dependencies=""/>' for i in range(1, 6)]
OUTPUTS3 += [f'<InitialUnknown valueReference="{i}" dependencies=""/>' for i in range(1, 6)]
TOLD = '<DefaultExperiment startTime="0" stopTime="1" tolerance="1e-4"/>'


def traced(version, *flags, experiment=TOLD, events=False):
    """The FMU of `traced2.c` or `traced3.c` as a source, compiled once for each choice of flags."""
    folder = kept_folder() / "-".join(["traced", str(version), str(events), *flags]).replace("=", "_")
    source = f'#include "traced{version}.c"'
    existing = folder / "library.so"
    binary = existing if existing.exists() else library(folder, version, source, *(f"-D{flag}" for flag in flags))
    if version is Version.FMI2:
        text = description2(VARIABLES2, OUTPUTS2, before=experiment, initial=OUTPUTS2)
    else:
        interface = f'<CoSimulation modelIdentifier="m" hasEventMode="{str(events).lower()}"/>'
        text = description3(VARIABLES3, OUTPUTS3, before=experiment, interface=interface)
    return Fmu(pack(folder / "m.fmu", version, text, binary))


def alone(source, **parameters):
    held = {"m.u": 4.0} if source.is_fmi2 else {}
    return System({"m": source.with_parameters(parameters)}, {}, held=held)


@pytest.fixture
def trace(tmp_path, monkeypatch):
    """The calls so far."""
    file = tmp_path / "trace.txt"
    monkeypatch.setenv("TRACE", str(file))
    return lambda: file.read_text().splitlines() if file.exists() else []


def finished(system, **options):
    """A simulation of 1 s in steps of 0.1 s that has been closed."""
    with Simulation(system, **({"h": 0.1, "until": 1.0} | options)) as simulation:
        simulation.run()
    return simulation


BOTH = pytest.mark.parametrize("version", [Version.FMI2, Version.FMI3])


def test_a_run_calls_in_the_order_of_the_standard_and_terminates(trace):
    finished(alone(traced(Version.FMI2), k=1.0), until=0.2)
    calls = [call for call in trace() if call != "set u"]
    assert calls == ["instantiate", "setup", "set k", "enter", "exit", "step", "step", "terminate", "free"]


def test_parameters_come_after_the_start_values_that_a_setup_loads():
    """Siblings of 20-sim's FMUs, which load their own start values in fmi2SetupExperiment."""
    messages = finished(alone(traced(Version.FMI2, "LOADS_STARTS"), k=3.0), until=0.1)._running.by_name["m"].messages
    assert len(messages) == 2  # k - 1 in each step


@BOTH
def test_an_fmu_is_told_the_tolerance_of_its_file_and_the_start_but_not_the_stop(version):
    columns = finished(alone(traced(version))).columns()
    assert {n: columns[f"m.{n}"][-1] for n in ("tolerance", "start", "stop")} == {
        "tolerance": 1e-4, "start": 0.0, "stop": -1.0
    }  # fmt: skip


@BOTH
def test_an_fmu_is_told_the_tolerance_and_the_start_that_a_person_wants(version):
    simulation = finished(alone(traced(version)), start=-0.5, until=0.5, tolerance=1e-9)
    columns = simulation.columns()
    assert (columns["m.tolerance"][-1], columns["m.start"][-1]) == (1e-9, -0.5)
    assert columns["time"].tolist() == pytest.approx([-0.5 + 0.1 * k for k in range(11)])
    assert columns["m.y"].tolist() == pytest.approx(columns["time"].tolist())


@pytest.mark.parametrize(
    ("version", "flag"),
    [
        (Version.FMI2, "NEEDS_STOP"),
        (Version.FMI2, "STOP_AT_SETUP"),
        (Version.FMI2, "STOP_AT_EXIT"),
        (Version.FMI3, "NEEDS_STOP"),
    ],
)
def test_an_fmu_that_does_not_run_without_the_stop_time_is_told_it(version, flag, trace):
    simulation = finished(alone(traced(version, flag)))
    columns = simulation.columns()
    assert columns["m.stop"][-1] == 1.0
    assert columns["m.y"][-1] == pytest.approx(1.0)
    assert simulation.remarks == ["unit `m`: it does not run without the stop time, so it was told 1 s"]
    assert trace().count("reset") == 1


@pytest.mark.parametrize("version", [Version.FMI2])
def test_a_first_step_that_fails_in_any_case_is_an_ordinary_fault(version):
    with pytest.raises(SimulationError) as error:
        finished(alone(traced(version, "FAILS_AT=0.05")))
    assert str(error.value) == "tick 0 (t = 0 s), unit `m`: `fmi2DoStep` returned an error"


@BOTH
@pytest.mark.parametrize("algorithm", ["sequential", "jacobi"])
def test_an_fmu_that_asks_for_the_end_ends_the_run_in_order(version, algorithm, trace):
    simulation = finished(alone(traced(version, "ENDS_AT=0.55")), algorithm=algorithm)
    columns = simulation.columns()
    reached = 0.55 if version is Version.FMI2 else pytest.approx(0.6)  # FMI 3.0 was not allowed to return early
    assert columns["time"][-1] == columns["m.y"][-1] == reached
    assert len(columns["time"]) == 7
    assert trace()[-2:] == ["terminate", "free"]
    assert simulation.ended.unit == "m"
    text = f"`m` asked for the end of the run at {columns['time'][-1]:g} s: the run ends there"
    assert simulation.remarks[0].startswith(text)


@pytest.mark.parametrize("flag", ["ENDS_AT=0.55", "ENDS_BY_EVENT=1.0"])
def test_with_event_mode_too(flag, trace):
    simulation = finished(alone(traced(Version.FMI3, flag, events=True)), until=2.0, algorithm="clocked")
    assert simulation.columns()["time"][-1] == simulation.ended.time == float(flag.split("=")[1])
    assert trace()[-2:] == ["terminate", "free"]


def test_other_units_complete_their_step_and_the_row_says_whose_values_are_older(trace):
    ends, goes_on = traced(Version.FMI2, "ENDS_AT=0.55"), traced(Version.FMI2)
    simulation = finished(System({"a": ends, "b": goes_on}, {}, held={"a.u": 4.0, "b.u": 4.0}))
    columns = simulation.columns()
    assert (columns["time"][-1], columns["a.y"][-1], columns["b.y"][-1]) == pytest.approx((0.6, 0.55, 0.6))
    assert simulation.remarks == [
        "`a` asked for the end of the run at 0.55 s: the run ends there, and its last row, at 0.6 s, has its values of"
        " then"
    ]
    assert trace().count("terminate") == 2


def test_a_unit_that_failed_is_not_terminated_and_the_others_are(trace):
    system = System({"a": traced(Version.FMI2, "FAILS_AT=0.25"), "b": traced(Version.FMI2)}, {}, {"a.u": 4, "b.u": 4})
    with pytest.raises(SimulationError):
        finished(system)
    assert trace().count("terminate") == 1
    assert trace().count("free") == 2


def test_an_end_that_fails_is_remarked():
    remarks = finished(alone(traced(Version.FMI2, "BAD_END"))).remarks
    assert remarks == ["unit `m`: it could not be terminated: fmi2Terminate failed with status 3 (error)."]


@pytest.mark.parametrize(
    ("flags", "algorithm"),
    [
        *(((), name) for name in ("sequential", "jacobi", "clocked")),
        *((("DEMANDS_EVENTS",), name) for name in ("sequential", "jacobi", "clocked")),
        *((("FLAGS_ANYWAY",), name) for name in ("sequential", "jacobi")),
    ],
)
def test_events_are_shown_at_their_time_whoever_handles_them(algorithm, flags):
    source = traced(Version.FMI3, *flags, events=True)
    simulation = finished(alone(source), h=0.5, until=3.0, algorithm=algorithm)
    assert simulation.columns()["m.n"].tolist() == [0, 0, 1, 1, 2, 2, 3]
    said = {
        ("DEMANDS_EVENTS",): ["unit `m`: it runs with Event Mode only, which it is given"],
        ("FLAGS_ANYWAY",): [
            "unit `m`: it asks for Event Mode, which was not promised to it; its events are left to itself"
        ],
    }
    assert simulation.remarks == said.get(flags, [])


def test_an_early_return_that_was_not_allowed_is_a_fault():
    with pytest.raises(SimulationError) as error:
        finished(alone(traced(Version.FMI3, "EARLY_UNASKED=0.35")))
    assert str(error.value) == (
        "tick 3 (t = 0.3 s), unit `m`: `fmi3DoStep` returned an error:"
        " the FMU returned early, at 0.35 s, which it was not allowed to"
    )


def test_an_fmu_is_asked_for_its_log_only_where_it_refuses_to_start(trace):
    finished(alone(traced(Version.FMI3)), until=0.1)
    assert trace()[0] == "instantiate"
    with pytest.raises(RequestError, match=r"refuses to make an instance \(Event Mode is needed\)"):
        fmu_unit("m", traced(Version.FMI3, "DEMANDS_EVENTS").archive)
    assert trace()[-1] == "instantiate, logging"


def test_both_versions_are_co_simulation_units():
    unit = fmu_unit("m", traced(Version.FMI2).archive)
    assert isinstance(unit, CoSimulationUnit)
    unit.close()
