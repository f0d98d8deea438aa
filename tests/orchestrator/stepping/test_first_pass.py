"""The first pass of the initialisation (`initialization.py`): no unit is given a value that nobody said.

The FMUs of these tests divide by their input or take its root, and start from values that only they know.
"""

from __future__ import annotations

import numpy as np
import pytest

from fmus.toolchain.version import Version
from orchestrator import Fmu, Simulation, SimulationError, System
from orchestrator.stepping.whole_run import simulate
from tests.fmus.foreign import description2, kept_folder, library, pack, scalar

CS, ME = '<CoSimulation modelIdentifier="m"/>', '<ModelExchange modelIdentifier="m"/>'
RECIPROCAL = ("2 + 1 / u", "u != 0")


def sensitive(name, rule, valid, *, start="4", declared=True, interface=CS, failure="fmi2Error"):
    """An FMU whose output `y` follows its input `u`, which it starts with itself; `z` follows nothing."""
    folder = kept_folder() / "sensitive" / name
    options = [f"-DRULE={rule}", f"-DVALID={valid}", f"-DSTART={start}", f"-DFAILURE={failure}"]
    binary = library(folder, Version.FMI2, '#include "sensitive2.c"', *options)
    variables = [scalar("y", 0, "output"), scalar("u", 1, "input", of_start=start), scalar("z", 2, "output")]
    depends = 'dependencies="2"' if declared else ""
    unknowns = [f'<Unknown index="1" {depends}/>', '<Unknown index="3" dependencies=""/>']
    text = description2(variables, unknowns, interface=interface, initial=unknowns)
    return Fmu(pack(folder / "m.fmu", Version.FMI2, text, binary))


def loop(source, other=None):
    return System({"a": source, "b": other or source}, {"b.u": "a.y", "a.u": "b.y"})


def test_units_that_feed_each_other_begin_with_their_start_values():
    frame = simulate(loop(sensitive("cs", *RECIPROCAL)), h=0.1, until=0.2, algorithm="jacobi")
    np.testing.assert_allclose(frame[["a.y", "b.y"]], 1 + np.sqrt(2), rtol=1e-9)


def test_so_do_model_exchange_units_whose_loop_is_solved():
    frame = simulate(loop(sensitive("me", *RECIPROCAL, interface=ME)), h=0.1, until=0.2, solve_loops=True)
    np.testing.assert_allclose(frame[["a.y", "b.y"]], 1 + np.sqrt(2), rtol=1e-9)


def test_a_plant_whose_sensor_divides_by_its_input_waits_for_the_controller():
    """No loop: the controller reads what follows no input; the plant must not be given the 0 of an unread output."""
    plant, controller = sensitive("plant", *RECIPROCAL), sensitive("control", "u + 4", "u > 0", start="1")
    system = System({"p": plant, "c": controller}, {"c.u": "p.z", "p.u": "c.y"})
    frame = simulate(system, h=0.1, until=0.2)
    assert frame["c.y"].tolist() == [5.0] * 3
    assert frame["p.y"].tolist() == [2 + 1 / 5] * 3


def test_values_that_a_unit_discards_make_the_solver_of_a_loop_try_others():
    """x = 20 sqrt(2 - x): from -50, a step of Newton leads to 31, where there is no root of 2 - x."""
    root = sensitive("root", "sqrt(2 - u)", "u <= 2", start="-50", interface=ME, failure="fmi2Discard")
    rest = sensitive("rest", "20 * u", "1", start="7.2", interface=ME)
    frame = simulate(loop(root, rest), h=0.1, until=0.1, solve_loops=True)
    np.testing.assert_allclose(frame["b.y"], 200 * (np.sqrt(1 + 2 / 100) - 1), rtol=1e-9)


def test_a_fault_of_the_initialisation_has_the_start_time():
    hopeless = sensitive("hopeless", "1", "0")
    with pytest.raises(SimulationError) as error:
        simulate(System({"a": hopeless}, {}, held={"a.u": 1.0}), h=0.1, until=0.2)
    assert str(error.value) == "tick 0 (t = 0 s), unit `a`: returned an error"
    jacobi = Simulation(loop(hopeless), h=0.1, until=9.0, start=7.0, algorithm="jacobi")
    with pytest.raises(SimulationError) as error, jacobi:
        pass
    assert str(error.value).startswith("tick 0 (t = 7 s), unit `")


def test_an_input_that_nobody_has_a_value_for_is_not_set():
    source = sensitive("alone", *RECIPROCAL, start="5")
    system = System({"a": source}, {}, unset={"a.u"})
    with Simulation(system, h=0.1, until=0.5) as simulation:
        simulation.step()
        assert simulation.read("a.y") == 2 + 1 / 5
        simulation.write("a.u", 2.0)
        simulation.step()
        simulation.step()
        assert simulation.read("a.y") == 2 + 1 / 2
        assert np.isnan(simulation.columns()["a.u"][0])
        assert simulation.columns()["a.u"][-1] == 2.0
