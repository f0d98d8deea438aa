"""The native stepper (`native_tables.py`) against the one in Python (`python_stepper.py`), and the `run_status.py`."""

from __future__ import annotations

import ctypes
import signal
import threading
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from components.interfaces.conversion import Linear
from components.interfaces.problem import RequestError
from components.interfaces.quantity import DTYPES, Type
from fmus.toolchain.stepper_library import stepper_library
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator.scenario import scenario_file
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.native_stepper import LONGEST_PERIOD, NativeStepper
from orchestrator.stepping.native_tables import layouts
from orchestrator.stepping.python_stepper import PythonStepper
from orchestrator.system.experiment import Algorithm
from orchestrator.system.input_table import InputColumn, InputTable
from orchestrator.system.source import Fmu, block_source
from orchestrator.system.system import System
from tests.fmus.foreign import description2, description3, kept_folder, library, pack, scalar
from tests.orchestrator.blocks import Gain
from tests.orchestrator.stepping.mixed import made

pytestmark = pytest.mark.skipif(stepper_library().library is None, reason="there is no compiler")


def rows(system, *, native, stops=(), **experiment):
    """All rows of a run, its remarks and what ended it, once stepped so and so; first to each of the `stops`."""
    simulation, ended = Simulation(system, native=native, **experiment), ""
    try:
        with simulation:
            for tick in stops:
                while simulation.tick < tick and not simulation.is_over:
                    simulation.step()
            simulation.run()
    except SimulationError as error:
        ended = str(error)
    columns = {name: column.tolist() for name, column in simulation.columns().items()}
    return columns, simulation.remarks, ended, simulation.tick, type(getattr(simulation, "_stepper", None))


def assert_same(system, stops=(), **experiment):
    """Both steppers give the same; returns what the native one gave."""
    python = rows(system, native=False, **experiment)
    native = rows(system, native=True, stops=stops, **experiment)
    assert (python[4], native[4]) in {(PythonStepper, NativeStepper), (type(None), type(None))}  # not initialised
    for name, column in python[0].items():
        np.testing.assert_array_equal(native[0][name], column, err_msg=name)
    assert native[:4] == python[:4] or native[1:4] == python[1:4]  # NaN is not equal to itself
    return native


@pytest.mark.parametrize("name", scenario_file.names())
def test_every_scenario_has_the_same_bits(name, built_fmus):
    scenario = prepare(name, Options(mode=Version.FMI3, stop_time=6.0))
    system, grid = scenario.system, {"h": scenario.h, "until": scenario.until}
    columns, *_ = assert_same(system, **grid, algorithm=scenario.algorithm)
    assert len(columns["time"]) == round(scenario.until / scenario.h) + 1


@pytest.mark.parametrize("mode", [*WRITTEN_VERSIONS, "blocks"], ids=str)
@pytest.mark.parametrize("algorithm", Algorithm)
def test_every_algorithm_has_the_same_bits(mode, algorithm, built_fmus):
    scenario = prepare("static", Options(mode=mode))
    assert_same(scenario.system, h=0.1, until=11.3, algorithm=algorithm, stops=(3, 40))


def held_values(names, wiring=()):
    """Values of all inputs that nothing drives."""
    values = {"a": 0.3, "v": [0.1, 0.2, 0.4], "s": 2.0, "n": 3, "b": [True, False, True], "c": 2}
    return {path: v for name in names for s, v in values.items() if (path := f"{name}.u.{s}") not in wiring}


@st.composite
def random_systems(draw):
    """Up to six units with signals of all types, connected at random, and how they are run."""
    names = [f"u{i}" for i in range(draw(st.integers(1, 6)))]
    versions = st.sampled_from([None, *WRITTEN_VERSIONS])
    kinds = st.sampled_from(["through", "follows", "acts"])
    units = {name: made(draw(kinds), draw(versions)) for name in names}
    wiring = {}
    loops = draw(st.integers(0, 3)) == 0
    for i, name in enumerate(names):
        for signal_name in ("a", "v", "s", "n", "b", "c"):
            source = draw(st.sampled_from([*(names if loops else names[:i]), None]))
            if source is not None:
                wiring[f"{name}.u.{signal_name}"] = f"{source}.y.{signal_name}"
        if f"{name}.u.v" not in wiring and (loops or i) and draw(st.booleans()):
            wiring[f"{name}.u.v[2]"] = f"{draw(st.sampled_from(names if loops else names[:i]))}.y.v[1]"
    held = held_values(names, wiring)
    steps = st.sampled_from([Fraction(1), Fraction(2), Fraction(3), Fraction(1, 2), Fraction(1, 3)])
    own = {n: draw(steps) for n in names if draw(st.booleans())}
    converted = {path: Linear(0.75, -0.5) for path in wiring if path.endswith((".a", ".v")) and draw(st.booleans())}
    system = System(units, wiring, held=held, steps=own, transformations=converted)
    record = draw(st.sampled_from([{"*": 1}, {"*": 3}, {"*.y.a": 1, "u0.*": 2}, {"*.y.v[2]": 1}]))
    return system, {
        "h": 0.25,
        "until": 0.25 * draw(st.integers(1, 40)),
        "start": draw(st.sampled_from([0.0, 1.5])),
        "algorithm": draw(st.sampled_from(list(Algorithm))),
        "solve_loops": True,
        "record": record,
    }


@pytest.mark.slow
@given(case=random_systems(), stops=st.lists(st.integers(0, 12), max_size=2))
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
def test_random_systems_have_the_same_bits(case, stops):
    system, experiment = case
    experiment["until"] += experiment["start"]
    try:
        assert_same(system, stops=sorted(stops), **experiment)
    except RequestError:
        with pytest.raises(RequestError):  # such as a loop through a unit with its own step
            rows(system, native=False, **experiment)


FAULTS = {
    "nothing": "",
    "a warning": "s = 1;",
    "discarded": "s = 2;",
    "an error": "s = 3;",
    "an unknown status": "s = 17;",
    "not a number": "i->x = 0.0 / 0.0;",
    "its end": "END",
    "an early return": "EARLY",
    "an event": "EVENT",
    "another time": "LATE",
    "a time that cannot be": "NEVER",
}
SOURCE = """
#include <stdlib.h>
#include "fmi%(v)sFunctions.h"
typedef struct { double u, x, k; int n, ended; double t; } I;
#if %(v)s == 2
#define END { i->ended = 1; s = 2; }
#define EARLY s = 2;
#define EVENT
#define LATE
#define NEVER
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String g, fmi2String r, const fmi2CallbackFunctions *f,
                              fmi2Boolean v, fmi2Boolean l) { return calloc(1, sizeof(I)); }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *v)
{ *v = ((I *)c)->ended; return fmi2OK; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *v) { *v = ((I *)c)->t; return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[])
#else
#define END *end = 1;
#define EARLY { *early = 1; *last = t + h / 2; }
#define EVENT *event = 1;
#define LATE *last = t + h / 2;
#define NEVER *last = 0.0 / 0.0;
fmi3Instance fmi3InstantiateCoSimulation(fmi3String n, fmi3String g, fmi3String r, fmi3Boolean v, fmi3Boolean l,
    fmi3Boolean e, fmi3Boolean a, const fmi3ValueReference q[], size_t m, fmi3InstanceEnvironment f,
    fmi3LogMessageCallback o, fmi3IntermediateUpdateCallback u) { return calloc(1, sizeof(I)); }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t m)
#endif
{
    I *i = c;
    for (size_t k = 0; k < n; ++k) *(vr[k] == 1 ? &i->u : &i->k) = v[k];
    return i->k > 0 && i->n == (int)i->k && %(set)d ? 3 : 0;
}
#if %(v)s == 2
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[])
#else
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t m)
#endif
{
    I *i = c;
    for (size_t k = 0; k < n; ++k) v[k] = vr[k] == 1 ? i->u : vr[k] == 2 ? i->x : i->k;
    return i->k > 0 && i->n == (int)i->k && %(get)d ? 3 : 0;
}
#if %(v)s == 2
fmi2Status fmi2DoStep(fmi2Component c, double t, double h, fmi2Boolean no)
#else
fmi3Status fmi3DoStep(fmi3Instance c, double t, double h, fmi3Boolean no, fmi3Boolean *event, fmi3Boolean *end,
                      fmi3Boolean *early, double *last)
#endif
{
    I *i = c;
    int s = 0;
#if %(v)s == 3
    *event = *end = *early = 0; *last = t + h;
#endif
    i->x += h * (i->u - i->x) + h;
    i->t = t + h / 2;
    if (i->n++ == (int)i->k) { %(fault)s }
    return s;
}
"""


def faulty(version, fault, *, call="step"):
    """An FMU of another maker that has a fault in its k-th step, or in the call of another function after it."""
    name = f"faulty{version}{call}{list(FAULTS).index(fault)}"
    path = kept_folder() / name / "m.fmu"
    if not path.exists():
        parts = {"v": version, "fault": FAULTS[fault], "set": call == "set", "get": call == "get"}
        binary = library(kept_folder() / name, version, SOURCE % parts)
        declared = [("u", 1, "input", "0"), ("x", 2, "output", None), ("k", 3, "parameter", "5")]
        if version == Version.FMI2:
            text = description2(
                [
                    scalar(
                        n,
                        r,
                        c,
                        **({"of_start": s} if s else {}),
                        **({"variability": "fixed"} if c == "parameter" else {}),
                    )
                    for n, r, c, s in declared
                ],
                ['<Unknown index="2" dependencies=""/>'],
            )
        else:
            variables = [
                f'<Float64 name="{n}" valueReference="{r}" causality="{c}"'
                + (f' start="{s}"' if s else "")
                + (' variability="fixed"' if c == "parameter" else "")
                + "/>"
                for n, r, c, s in declared
            ]
            text = description3(variables, ['<Output valueReference="2" dependencies=""/>'])
        pack(path, version, text, binary)
    return Fmu(path)


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=str)
@given(tick=st.integers(0, 12), parts=st.sampled_from([Fraction(1), Fraction(1, 2), Fraction(3)]))
@settings(max_examples=8, deadline=None)
def test_a_fault_at_any_tick_ends_in_the_same_way(version, fault, tick, parts):
    one = faulty(version, fault).with_parameters({"k": float(tick)})
    units = {"one": one, "two": faulty(version, "nothing")}
    system = System(units, {"one.u": "two.x", "two.u": "one.x"}, steps={"one": parts})
    assert_same(system, h=0.5, until=5.0)


@pytest.mark.parametrize("call", ["set", "get"])
@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=str)
def test_a_value_that_is_refused_is_told_with_the_function(version, call):
    one = faulty(version, "nothing", call=call).with_parameters({"k": 5.0})
    system = System({"one": one}, {}, held={"one.u": 1.0})
    *_, ended, tick, _ = assert_same(system, h=0.5, until=5.0)
    function = {"set": "Set", "get": "Get"}[call] + {2: "Real", 3: "Float64"}[int(version)]
    assert f"`fmi{version}{function}` returned an error" in ended
    assert tick == {"set": 5, "get": 4}[call]


def test_a_table_is_followed():
    times = np.linspace(0, 5, 11)
    values = {("a", 0, Type.FLOAT64): times * 1.5, ("b", 1, Type.BOOLEAN): times > 2, ("n", 0, Type.INT32): times // 1}
    columns = tuple(
        InputColumn("s", f"u.{n}", i, f"s.u.{n}", kind, values.astype(DTYPES[kind]), hold=kind is not Type.FLOAT64)
        for (n, i, kind), values in values.items()
    )
    units = {"s": made("follows", Version.FMI3), "t": made("acts", Version.FMI2)}
    table = InputTable(times, columns, hold=False, file_suffix=".csv", content=b"")
    system = System(units, {"t.u": "s.y"}, held=held_values("s"), table=table)
    columns, *_ = assert_same(system, h=0.1, until=5.0)
    assert {True, False} == set(columns["s.y.b[1]"])


def test_what_is_written_by_hand_acts_alike(built_fmus):
    scenario = prepare("static", Options(mode=Version.FMI2))

    def run(native):
        with Simulation(scenario.system, h=0.1, until=5.0, native=native) as simulation:
            for _ in range(10):
                simulation.step()
            simulation.write("plant.actuation.delta_f", 0.02)
            for _ in range(5):
                simulation.step()
            simulation.release("plant.actuation.delta_f")
            simulation.run()
            return simulation.columns()

    python, native = run(native=False), run(native=True)
    for name, column in python.items():
        np.testing.assert_array_equal(native[name], column)


def test_ctrl_c_comes_between_two_ticks_and_loses_none(built_fmus):
    system = System({"s": made("follows", Version.FMI3)}, {}, held=held_values("s"))
    with Simulation(system, h=0.1, until=2e5) as simulation:
        simulation.open()
        former = signal.signal(signal.SIGALRM, lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        try:
            with pytest.raises(KeyboardInterrupt):
                simulation.run()
        finally:
            signal.signal(signal.SIGALRM, former)
        stopped = simulation.tick
        assert 0 < stopped < simulation.last_tick
        assert len(simulation.columns()["time"]) == stopped + 1
        for _ in range(3):
            simulation.step()
        went_on = simulation.columns()
    with Simulation(system, h=0.1, until=0.1 * (stopped + 3), native=False) as simulation:
        simulation.run()
        for name, column in simulation.columns().items():
            np.testing.assert_array_equal(went_on[name], column)


def test_other_threads_run_meanwhile():
    system = System({"s": made("follows", Version.FMI2)}, {}, held=held_values("s"))
    counted = [0]
    done = threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1

    with Simulation(system, h=0.1, until=1e5) as simulation:
        simulation.open()
        other = threading.Thread(target=count)
        other.start()
        try:
            simulation.run()
            assert counted[0] > 1000
        finally:
            done.set()
            other.join()


def test_eight_threads_with_a_simulation_each_give_the_same_bits(built_fmus):
    system = prepare("static", Options(mode=Version.FMI2)).system
    found = {}

    def run(number):
        with Simulation(system, h=0.1, until=60.0) as simulation:
            simulation.run()
            found[number] = simulation.columns()

    threads = [threading.Thread(target=run, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for number in range(1, 8):
        for name, column in found[0].items():
            np.testing.assert_array_equal(found[number][name], column)


def test_a_pattern_that_is_too_long_is_left_to_python():
    primes = {f"u{p}": Fraction(p) for p in (2, 3, 5, 7, 11, 13)}
    assert np.prod([float(p) for p in primes.values()]) > LONGEST_PERIOD
    system = System(
        {name: block_source(Gain(k=1.0)) for name in primes},
        {},
        held={f"{name}.a.value": 1.0 for name in primes},
        steps=primes,
    )
    with Simulation(system, h=0.1, until=1.0) as simulation:
        simulation.run()
        assert type(simulation._stepper) is PythonStepper


def test_the_tables_have_the_layout_of_the_library():
    found, ours = layouts(stepper_library().library)
    assert found == ours
    assert isinstance(stepper_library().library, ctypes.CDLL)
