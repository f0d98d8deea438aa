"""Systems of a thousand units: what is done for them grows in proportion to them, and their numbers are right.

Growth is shown without a clock, by the operations of Python that are counted. Shows `unit_problems.py`, too.
"""

from __future__ import annotations

import gc
import sys

import numpy as np
import pytest

from components.interfaces.problem import MOST_PROBLEMS, RequestError
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.schedule import schedule
from orchestrator.system.experiment import Algorithm
from orchestrator.system.source import block_source
from orchestrator.system.system import System
from tests.orchestrator.blocks import Affine
from tests.orchestrator.large import PORTS, of_blocks, source_of, ssp_of_units
from tests.orchestrator.ssps import binding, bindings, body, component, connectors, echo, system, values, wire, write


def operations(action):
    """How many operations of the interpreter an action takes."""
    count = 0

    def trace(frame, event, _argument):
        nonlocal count
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        count += event == "opcode"
        return trace

    gc.disable()
    before = sys.gettrace()
    sys.settrace(trace)
    try:
        action()
    finally:
        sys.settrace(before)
        gc.enable()
    return count


def assert_linear(prepared, *sizes):
    """Four times as much takes four times as long, but for what does not depend on it.

    `prepared` gives the action for a size; what is made once for all sizes has been made before it is counted.
    """
    small, large = sizes or (20, 80)
    for n in (small, large):
        prepared(n)()
    few, many = (operations(prepared(n)) for n in (small, large))
    assert many < 1.25 * large / small * few


def chain(units, *, ring=False):
    """Units that show their inputs at once, each reading the one before it."""
    made = {f"u{k}": block_source(Affine(k=0.5, d=1.0)) for k in range(units)}
    wiring = {f"u{k}.a": f"u{k - 1}.b" for k in range(1, units)}
    last = {"u0.a": f"u{units - 1}.b"} if ring else {}
    return System(made, wiring | last, {} if ring else {"u0.a.value": 1.0})


@pytest.mark.parametrize("turned", [False, True])
def test_a_system_is_checked_and_prepared_in_proportion(turned):
    assert_linear(lambda n: lambda: of_blocks(n, turned=turned))

    def prepared(n):
        made = of_blocks(n, turned=turned)
        return lambda: Simulation(made, h=0.1, until=0.3)

    assert_linear(prepared)


def test_a_system_is_opened_and_stepped_in_proportion():
    def prepared(n):
        simulation = Simulation(of_blocks(n), h=0.1, until=0.3)

        def run():
            with simulation:
                simulation.run()
                simulation.columns()

        return run

    assert_linear(prepared)


@pytest.mark.parametrize("algorithm", Algorithm)
def test_the_order_of_a_chain_is_found_in_proportion(algorithm):
    def prepared(n):
        made = chain(n)
        return lambda: schedule(made, algorithm)

    assert_linear(prepared, 50, 200)


def test_loops_are_found_in_proportion():
    def prepared(n):
        made = chain(n, ring=True)
        return lambda: schedule(made, solve_loops=True)

    assert len(schedule(chain(50, ring=True), solve_loops=True).loops[0]) == 50
    assert_linear(prepared, 50, 200)


def wide(folder, n):
    """Two units that read all of each other."""
    fmu = echo(folder / "wide.fmu", [f"u{i}" for i in range(n)])
    ports = connectors(*[f"u{i}:input" for i in range(n)], *[f"y_u{i}:output" for i in range(n)])
    wires = "".join(wire(f"{a}.y_u{i}", f"{b}.u{i}") for a, b in ("xy", "yx") for i in range(n))
    elements = "".join(component(name, "wide.fmu", ports) for name in "xy")
    return write(folder / f"wide{n}.ssp", body(elements, wires), {"resources/wide.fmu": fmu})


def valued(folder, n):
    """A unit whose parameters all have a value."""
    fmu = echo(folder / "valued.fmu", ["u"], [f"p{i}" for i in range(n)])
    inside = connectors("u:input", "y_u:output") + bindings(binding(values(**{f"p{i}": i for i in range(n)})))
    return write(folder / f"valued{n}.ssp", body(component("c", "valued.fmu", inside)), {"resources/valued.fmu": fmu})


def nested(folder, n):
    """Connections through a system in a system."""
    fmu = echo(folder / "nested.fmu", [f"u{i}" for i in range(n)])
    ports = connectors(*[f"u{i}:input" for i in range(n)], *[f"y_u{i}:output" for i in range(n)])
    inside, name = component("c", "nested.fmu", ports), "c"
    for depth in range(2):
        through = "".join(wire(f"u{i}", f"{name}.u{i}") + wire(f"{name}.y_u{i}", f"y_u{i}") for i in range(n))
        inside, name = system(f"s{depth}", inside, through, ports), f"s{depth}"
    wires = "".join(wire(f"{name}.y_u{i}", f"{name}.u{i}") for i in range(n))
    return write(folder / f"nested{n}.ssp", body(inside, wires), {"resources/nested.fmu": fmu})


@pytest.mark.parametrize("made", [ssp_of_units, wide, valued, nested])
def test_an_ssp_is_read_in_proportion(tmp_path, made):
    small, large = (20, 80) if made is ssp_of_units else (100, 400)
    files = {n: made(tmp_path, n) for n in (small, large)}
    assert_linear(lambda n: lambda: load(files[n], Options()), small, large)


def test_of_very_many_problems_the_first_are_told(tmp_path):
    fmu = echo(tmp_path / "unit.fmu", ["u"])
    elements = component("c", "unit.fmu", connectors("u:input", "y_u:output"))

    def wrong(n):
        wires = "".join(wire(f"c.y_u{i}", f"d{i}.u") for i in range(n))
        return write(tmp_path / "wrong.ssp", body(elements, wires), {"resources/unit.fmu": fmu})

    for n, more in ((MOST_PROBLEMS // 2, 0), (MOST_PROBLEMS, 1)):
        with pytest.raises(RequestError) as error:
            load(wrong(n), Options())
        assert len(error.value.problems) == min(2 * n, MOST_PROBLEMS) + more
    assert str(error.value.problems[-1]) == (
        "other problems: found more than these 1000; valid: none. Correct these first: the others are not listed."
    )
    units = {"u": block_source(Affine(k=0.5, d=1.0))}
    with pytest.raises(RequestError) as error:
        System(units, {f"v{i}.a": "u.b" for i in range(2 * MOST_PROBLEMS)})
    assert len(error.value.problems) == MOST_PROBLEMS + 1
    assert str(error.value).count("\n") == MOST_PROBLEMS


@pytest.mark.slow
def test_a_thousand_units_with_ten_thousand_connections_give_the_numbers_that_they_must():
    n, ticks = 1000, 10
    sources = np.array([[source_of(unit, i, n) for i in range(len(PORTS))] for unit in range(n)])
    expected = np.repeat(np.arange(n, dtype=float)[:, None], len(PORTS), axis=1)
    forward, turned = (Simulation(of_blocks(n, turned=t), h=0.1, until=0.1 * ticks) for t in (False, True))
    assert len(forward.system.connections) == 10_000
    with forward, turned:
        forward.run()
        turned.run()
        rows, others = forward.columns(), turned.columns()
    assert {*rows} == {*others}
    for tick in range(ticks + 1):
        for table in (rows, others):
            found = [[table[f"u{unit}.y.{port}"][tick] for port in PORTS] for unit in range(n)]
            assert np.array_equal(found, expected)
        expected = (expected + expected[sources, np.arange(len(PORTS))]) / 2


def test_what_is_the_same_several_times_is_said_once(tmp_path):
    fmu = echo(tmp_path / "unit.fmu", ["u"])
    elements = component("c", "unit.fmu", connectors("u:input", "y_u:output", "z:input"))
    twice = wire("c.y_u", "c.z") * 2
    path = write(tmp_path / "same.ssp", body(elements, twice), {"resources/unit.fmu": fmu})
    with pytest.raises(RequestError) as error:
        load(path, Options())
    assert len({*error.value.problems}) == len(error.value.problems)
