"""The equals of the Reference FMUs against a computation of the same recurrences, and of the same equations.

The Co-Simulation ones are equal bit by bit under every algorithm, in this process and in one of their own.
"""
# pyright: basic
# scipy carries few types.

from __future__ import annotations

import math
import sys
from itertools import count

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.reading.opening import open_fmu
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator import SILENT, Fmu, Options, Simulation, System, load
from tests.fmus.reference_fmus import MODELS, PAIRS, reference_fmu

CO, ME = "CoSimulation", "ModelExchange"
VERSIONS = pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=["fmi2", "fmi3"])
ALGORITHMS = pytest.mark.parametrize("algorithm", ["sequential", "jacobi", "clocked"])
PROCESSES = pytest.mark.parametrize(
    "isolated", [pytest.param(None, id="here"), pytest.param(30.0, id="isolated", marks=pytest.mark.slow)]
)
IN_FMI2 = ("Float64_continuous", "Float64_discrete", "Int32", "Boolean", "String", "Enumeration")


def ball(step=1e-3, g=-9.81, e=0.7):
    """Height and speed after each internal step."""
    h, v = 1.0, 0.0
    while True:
        yield h, v
        h, v = h + step * v, v + step * g
        if h <= 0 and v < 0:
            h, v = sys.float_info.min, -v * e
            if v < 0.1:
                v = g = 0.0


def dahlquist(step=0.1, k=1.0, x=1.0):
    while True:
        yield (x,)
        x += step * (-k * x)


def van_der_pol(step=1e-2, mu=1.0, x0=2.0):
    x1 = 0.0
    while True:
        yield x0, x1
        x0, x1 = x0 + step * x1, x1 + step * (mu * ((1.0 - x0 * x0) * x1) - x0)


def stair(step=0.2):
    for n in count():
        yield (1 + math.floor(n * step + 1e-9),)


TRUTHS = {
    "bouncing_ball": (ball, 1e-3, ("h", "v"), {"e": 0.6}),
    "dahlquist": (dahlquist, 0.1, ("x",), {"k": 2.0, "x": 0.5}),
    "van_der_pol": (van_der_pol, 1e-2, ("x0", "x1"), {"mu": 3.0, "x0": 1.5}),
    "stair": (stair, 0.2, ("counter",), {}),
}


def truth(name, h, n, **parameters):
    """The values at n + 1 communication points `h` [s] apart: those after the last whole internal step."""
    recurrence, step, signals, _ = TRUTHS[name]
    steps = [math.floor(k * h / step + 1e-6) for k in range(n + 1)]
    states = recurrence(**parameters)
    values = [next(states) for _ in range(steps[-1] + 1)]
    return {f"m.{signal}": [values[i][at] for i in steps] for at, signal in enumerate(signals)}


def finished(source, held=None, **options):
    """A simulation that has been closed."""
    with Simulation(System({"m": source}, {}, held=held or {}), **options) as simulation:
        simulation.run()
    return simulation


def rows(name, version, interface, parameters=None, *, isolated=None, **options):
    source = Fmu(reference_fmu(name, version, interface), parameters or {}, isolated=isolated)
    return finished(source, **options).frame()


@pytest.mark.parametrize("name", TRUTHS)
@VERSIONS
@ALGORITHMS
def test_co_simulation_is_equal_bit_by_bit(name, version, algorithm):
    h, n = {"bouncing_ball": (0.01, 300), "stair": (0.2, 45)}.get(name, (0.1, 100))
    found = rows(name, version, CO, h=h, until=n * h, algorithm=algorithm)
    for signal, values in truth(name, h, n).items():
        assert found[signal].tolist() == values
    assert found["time"].tolist() == [k * h for k in range(n + 1)]


@VERSIONS
@ALGORITHMS
@PROCESSES
def test_units_of_one_system_are_equal_bit_by_bit(version, algorithm, isolated):
    units = {name: Fmu(reference_fmu(name, version, CO), isolated=isolated) for name in TRUTHS}
    with Simulation(System(units, {}), h=0.2, until=8.8, algorithm=algorithm) as simulation:
        simulation.run()
    for name in TRUTHS:
        for signal, values in truth(name, 0.2, 44).items():
            assert simulation.columns()[signal.replace("m.", f"{name}.")].tolist() == values


@pytest.mark.parametrize("name", ["bouncing_ball", "dahlquist", "van_der_pol"])
@VERSIONS
@ALGORITHMS
def test_parameters_and_start_values_of_states_arrive(name, version, algorithm):
    wanted = TRUTHS[name][3]
    found = rows(name, version, CO, wanted, h=0.1, until=2.0, algorithm=algorithm)
    for signal, values in truth(name, 0.1, 20, **wanted).items():
        assert found[signal].tolist() == values


@pytest.mark.parametrize(("name", "h"), [("bouncing_ball", 0.0025), ("dahlquist", 0.25), ("van_der_pol", 0.025)])
@VERSIONS
@ALGORITHMS
def test_an_internal_step_that_does_not_divide_the_macro_step_waits(name, h, version, algorithm):
    found = rows(name, version, CO, h=h, until=40 * h, algorithm=algorithm)
    for signal, values in truth(name, h, 40).items():
        assert found[signal].tolist() == values


@pytest.mark.parametrize("start", [-1.0, 2.0])
@VERSIONS
def test_runs_may_begin_anywhere(start, version):
    found = rows("van_der_pol", version, CO, h=0.1, start=start, until=start + 1.0)
    assert found["m.x0"].tolist() == truth("van_der_pol", 0.1, 10)["m.x0"]
    counted = rows("stair", version, CO, h=0.2, start=-1.0, until=3.0)
    assert counted["m.counter"].tolist() == [max(1, 1 + math.floor(-1 + 0.2 * k + 1e-9)) for k in range(21)]


@VERSIONS
@ALGORITHMS
@pytest.mark.parametrize("interface", [CO, ME])
def test_stair_ends_the_run_itself(version, algorithm, interface):
    source = Fmu(reference_fmu("stair", version, interface))
    simulation = finished(source, h=0.2, until=10.0, algorithm=algorithm)
    assert simulation.columns()["m.counter"].tolist() == truth("stair", 0.2, 45)["m.counter"]
    assert simulation.columns()["time"][-1] == pytest.approx(9.0)
    assert str(simulation.ended) == "`m` asked for the end of the run at 9 s"


@VERSIONS
def test_default_experiments_are_used(version):
    wanted = {"bouncing_ball": (0.01, 3.0), "dahlquist": (0.1, 10.0), "stair": (0.2, 10.0), "van_der_pol": (0.01, 20.0)}
    for name, experiment in wanted.items():
        request = load(str(reference_fmu(name, version)), Options(), SILENT)
        assert (request.h, request.until, list(request.remarks)) == (*experiment, [])


@VERSIONS
@PROCESSES
@pytest.mark.parametrize("interface", [CO, ME])
def test_resources_are_found(version, isolated, interface):
    found = rows("resource", version, interface, isolated=isolated, h=1.0, until=3.0)
    assert found["m.y"].tolist() == [ord("a")] * 4


EXTREME = {
    "Float32_continuous": 0.1,
    "Float32_discrete": -3.4e38,
    "Float64_continuous": 5e-324,
    "Float64_discrete": 1 / 3,
    **{
        f"{kind}{bits}": n
        for bits in (8, 16, 32, 64)
        for kind, n in (("Int", -(2 ** (bits - 1))), ("UInt", 2**bits - 1))
    },
    "Boolean": True,
    "String": "gr\u00fc\u00df 'dich' \n & <mich>",
    "Binary": b"a\0b\xff",
    "Enumeration": 2,
}


@VERSIONS
@ALGORITHMS
@PROCESSES
@pytest.mark.parametrize("interface", [CO, ME])
def test_values_of_every_type_pass_through_two_units(version, algorithm, isolated, interface):
    names = [n for n in PAIRS.values() if version is Version.FMI3 or n in IN_FMI2]
    path = reference_fmu("feedthrough", version, interface)
    system = System(
        {"a": Fmu(path, isolated=isolated), "b": Fmu(path)},
        {f"b.{n}_input": f"a.{n}_output" for n in names},
        held={f"a.{n}_input": EXTREME[n] for n in names},
    )
    with Simulation(system, h=0.1, until=0.4, algorithm=algorithm) as simulation:
        for tick in simulation:
            if tick.tick == 1:
                simulation.write("a.Int32_input", 7)
        columns = simulation.columns()
    late = algorithm == "jacobi"
    for unit in "ab":
        for n in names:
            shown = columns[f"{unit}.{n}_output"].tolist()
            expected = [EXTREME[n]] * 5
            if n == "Int32":
                old = 3 if late and unit == "b" else 2
                expected = expected[:old] + [7] * (5 - old)
            if n.startswith("Float32"):
                expected = np.array(expected, np.float32).tolist()
            assert shown == expected


@VERSIONS
def test_descriptions_break_no_rule(version):
    for name in MODELS:
        assert open_fmu(reference_fmu(name, version)).remarks == ()


def fall(t, e=0.7, g=9.81):
    """Height and speed of the ball in truth: it lands, jumps with e times its speed, and rests below 0.1 m/s."""
    lands, up = math.sqrt(2 / g), e * math.sqrt(2 * g)
    if t < lands:
        return 1 - g * t * t / 2, -g * t
    while up >= 0.1:
        if t < lands + 2 * up / g:
            s = t - lands
            return up * s - g * s * s / 2, up - g * s
        lands, up = lands + 2 * up / g, e * up
    return 0.0, 0.0


@VERSIONS
@ALGORITHMS
def test_model_exchange_is_as_the_solution(version, algorithm):
    options = {"h": 0.05, "until": 5.0, "algorithm": algorithm}
    found = rows("dahlquist", version, ME, {"k": 2.0}, **options)
    assert found["m.x"].to_numpy() == pytest.approx(np.exp(-2 * found["time"].to_numpy()), abs=1e-6)
    found = rows("bouncing_ball", version, ME, **options)
    expected = np.array([fall(t) for t in found["time"]])
    assert found["m.h"].to_numpy() == pytest.approx(expected[:, 0], abs=1e-6)
    assert found["m.v"].to_numpy() == pytest.approx(expected[:, 1], abs=1e-5)


@VERSIONS
@PROCESSES
def test_the_oscillator_is_as_another_integrator_has_it(version, isolated):
    found = rows("van_der_pol", version, ME, {"mu": 2.0}, isolated=isolated, h=0.1, until=20.0, tolerance=1e-11)
    exact = solve_ivp(
        lambda _, x: [x[1], 2.0 * (1 - x[0] * x[0]) * x[1] - x[0]],
        (0.0, 20.0),
        [2.0, 0.0],
        method="DOP853",
        t_eval=np.minimum(found["time"], 20.0),
        rtol=1e-12,
        atol=1e-12,
    ).y
    assert found["m.x0"].to_numpy() == pytest.approx(exact[0], abs=1e-7)
    assert found["m.x1"].to_numpy() == pytest.approx(exact[1], abs=1e-7)
