"""A simulation that goes back to its start gives the bits of a new one, whatever its units are.

Shows `simulation_pool.py`, and what `master.py`, `running_units.py` and `lifetime.py` do for it.
"""

from __future__ import annotations

import gc
import resource
import subprocess
import sys
from pathlib import Path
from threading import Barrier, Thread

import pytest

from components.interfaces.problem import RequestError
from fmus.reading.kept_files import KeptFiles
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from fmus.units.fmu_unit import FmuUnit
from fmus.units.unit import UnitError
from orchestrator import Fmu, Options, Simulation, SimulationError, SimulationPool, System, load
from tests.fmus.reference_fmus import reference_fmu

CO, ME = "CoSimulation", "ModelExchange"
CHANGED = {"plant.m": 1500.0, "plant.v_x_start": 12.0, "controller.mu": 0.45}


def frames(simulation):
    """The rows and the remarks of a whole run."""
    simulation.run()
    return simulation.frame(), simulation.remarks


def assert_begins_anew(make, values):
    """A run, one with other values after a reset, and one with the first values again, against new simulations."""
    with make({}) as simulation:
        first = frames(simulation)
        simulation.reset(values)
        changed = frames(simulation)
        simulation.reset()
        for _ in range(5):  # from the middle of a run
            simulation.step()
        simulation.reset()
        again = frames(simulation)
    for (rows, remarks), given in ((first, {}), (changed, values), (again, {})):
        with make(given) as new:
            expected, said = frames(new)
        assert rows.equals(expected)
        assert remarks == said
    assert not changed[0].equals(first[0])


@pytest.fixture(params=["blocks", Version.FMI2, Version.FMI3], ids=str)
def static(request, built_fmus):
    return load("static", Options(mode=request.param))


@pytest.mark.parametrize("mode", ["blocks", Version.FMI2, Version.FMI3], ids=str)
@pytest.mark.parametrize("algorithm", ["sequential", "clocked"])
def test_the_static_scenario_begins_anew_with_other_parameters(built_fmus, mode, algorithm):
    def make(values):
        made = load("static", Options(mode=mode, settings=[f"{path}={value}" for path, value in values.items()]))
        return Simulation(made.system, h=made.h, until=5.0, algorithm=algorithm)

    assert_begins_anew(make, CHANGED)


def test_units_in_processes_of_their_own_begin_anew(built_fmus):
    def make(values):
        options = Options(isolate=["plant"], settings=[f"{path}={value}" for path, value in values.items()])
        made = load("static", options)
        return Simulation(made.system, h=made.h, until=2.0)

    assert_begins_anew(make, CHANGED)


@pytest.mark.parametrize("isolated", [None, 30.0], ids=["here", "isolated"])
@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=str)
@pytest.mark.parametrize("interface", [CO, ME])
@pytest.mark.parametrize(("name", "values"), [("bouncing_ball", {"m.e": 0.6}), ("van_der_pol", {"m.mu": 2.0})])
def test_fmus_of_every_kind_begin_anew(name, values, interface, version, isolated):
    file = reference_fmu(name, version, interface)

    def make(given):
        parameters = {path.partition(".")[2]: value for path, value in given.items()}
        return Simulation(System({"m": Fmu(file, parameters, isolated=isolated)}, {}), h=0.1, until=2.0)

    assert_begins_anew(make, values)


def test_what_was_written_and_released_is_forgotten(built_fmus):
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=2.0) as simulation:
        expected, _ = frames(simulation)
        simulation.reset()
        simulation.step()
        simulation.write("plant.actuation.delta_f", 0.1)
        simulation.write("controller.mu", 0.3)
        assert "plant.actuation.delta_f" in frames(simulation)[0]
        simulation.reset()
        assert (simulation.tick, simulation.time, len(simulation.frame())) == (-1, 0.0, 0)
        assert frames(simulation)[0].equals(expected)


def test_rows_that_were_given_stay_as_they_are(built_fmus):
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=1.0) as simulation:
        simulation.run()
        columns, times = simulation.columns(), simulation.step_times
        kept = {name: values.copy() for name, values in columns.items()}
        simulation.reset({"plant.v_x_start": 5.0})
        simulation.run()
        assert all((columns[name] == kept[name]).all() for name in kept)
        assert times.all()


def test_the_system_has_the_values_of_the_run_and_a_parameter_is_released_to_them(built_fmus):
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=1.0) as simulation:
        simulation.reset({"controller.mu": 0.4})
        assert simulation.system.units["controller"].parameters["mu"] == 0.4
        assert made.system.units["controller"].parameters["mu"] != 0.4
        simulation.write("controller.mu", 0.3)
        simulation.release("controller.mu")
        simulation.step()
        assert simulation.columns()["controller.mu"].tolist() == [0.4]


def test_wrong_parameters_are_refused_all_at_once_and_change_nothing(built_fmus):
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=1.0) as simulation:
        simulation.step()
        with pytest.raises(RequestError) as error:
            simulation.reset({"plant.m": -1.0, "plant.mass": 2.0, "car.m": 1.0})
        assert [problem.where for problem in error.value.problems] == ["plant.m", "plant.mass", "car.m"]
        assert simulation.tick == 0
        simulation.run()
    with pytest.raises(RequestError) as error:
        simulation.reset({3: 4})
    assert "Simulation.reset: parameters" in str(error.value)


def test_a_simulation_that_was_closed_is_told(static):
    with Simulation(static.system, h=static.h, until=0.3) as simulation:
        simulation.run()
    with pytest.raises(RequestError) as error:
        simulation.reset()
    assert [str(problem) for problem in error.value.problems] == [
        "simulation: found closed at 0.3 s; its rows stay; valid: one that is open."
        " Make another Simulation of the system."
    ]


def test_without_a_with_statement_the_units_are_opened_again(static):
    simulation = Simulation(static.system, h=static.h, until=0.3)
    simulation.reset({"plant.v_x_start": 9.0})  # before anything was opened
    assert simulation._lifetime.is_new
    simulation.run()
    assert not simulation._lifetime.is_open
    simulation.reset({"plant.v_x_start": 8.0})
    assert simulation.read("plant.state.v_x") == 8.0
    simulation.run()
    assert len(simulation.frame()) == 4
    simulation.reset()
    simulation.close()
    with pytest.raises(RequestError, match="closed at 0 s"):
        simulation.step()


def test_a_unit_that_has_failed_or_cannot_be_reset_is_opened_again(built_fmus, monkeypatch):
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=0.5) as simulation:
        expected, _ = frames(simulation)
        units = {**simulation._running.by_name}

        def refuse(*_):
            raise UnitError("plant", "no", ())

        monkeypatch.setattr(units["plant"], "reset", refuse)
        monkeypatch.setattr(units["traffic"], "terminate", refuse)
        simulation._running.failed = "controller"
        simulation.reset()
        assert not any(simulation._running.by_name[name] is units[name] for name in units)
        assert frames(simulation)[0].equals(expected)


def test_a_unit_that_cannot_be_opened_again_is_a_fault_at_the_start(built_fmus, monkeypatch):
    made = load("static", Options())

    def refuse(*_):
        raise UnitError("plant", "its process died", ())

    with Simulation(made.system, h=made.h, until=0.5) as simulation:
        simulation.run()
        monkeypatch.setattr(simulation._running.by_name["plant"], "reset", refuse)
        monkeypatch.setattr(Fmu, "open", refuse)
        with pytest.raises(SimulationError) as error:
            simulation.reset()
    assert (error.value.tick, error.value.unit, error.value.reason) == (0, "plant", "its process died")


def test_units_are_not_opened_again_otherwise(static, monkeypatch):
    with Simulation(static.system, h=static.h, until=0.5) as simulation:
        units = {**simulation._running.by_name}
        simulation.run()
        simulation.reset()
        assert all(simulation._running.by_name[name] is unit for name, unit in units.items())


def test_a_reset_that_fails_closes_all(built_fmus, monkeypatch):
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=0.5) as simulation:
        monkeypatch.setattr(FmuUnit, "_set_parameters", lambda unit, *_, **__: unit.exit_initialization())
        with pytest.raises(SimulationError):
            simulation.reset()
        with pytest.raises(RequestError, match="closed"):
            simulation.step()


def test_what_several_units_have_to_say_stands_there_once(built_fmus, monkeypatch):
    remark = "as the cache cannot be used"
    monkeypatch.setattr("fmus.units.fmu_unit.kept_files", lambda _: KeptFiles(None, remark))
    made = load("static", Options())
    with Simulation(made.system, h=made.h, until=0.2) as simulation:
        simulation._running.by_name["plant"].remark("of one alone")
        names = ", ".join(f"`{name}`" for name in made.system.units)
        assert simulation.remarks == [f"units {names}: {remark}", "unit `plant`: of one alone"]
        simulation.reset()
        assert simulation.remarks == [f"units {names}: {remark}"]


def test_a_pool_keeps_simulations_open_for_the_next_run(static):
    made = []

    def make():
        made.append(Simulation(static.system, h=static.h, until=0.5))
        return made[-1]

    with SimulationPool(make) as pool:
        with pool.simulation({"plant.v_x_start": 9.0}) as first:
            first.run()
            with pool.simulation() as other:
                assert other is not first
        with pool.simulation() as again:
            assert again in made
            rows, _ = frames(again)
        assert len(made) == 2
        with pytest.raises(ZeroDivisionError), pool.simulation():
            _ = 1 / 0
        assert sum(simulation._lifetime.is_open for simulation in made) == 1
    with Simulation(static.system, h=static.h, until=0.5) as new:
        assert frames(new)[0].equals(rows)
    assert not any(simulation._lifetime.is_open for simulation in made)


def test_threads_do_not_share_a_simulation_of_a_pool(static):
    both, found = Barrier(2), []

    def run(speed):
        with pool.simulation({"plant.v_x_start": speed}) as simulation:
            both.wait()
            simulation.run()
            found.append((speed, simulation.frame()["plant.state.v_x"][0]))

    with SimulationPool(lambda: Simulation(static.system, h=static.h, until=0.5)) as pool:
        threads = [Thread(target=run, args=(speed,)) for speed in (8.0, 9.0)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert sorted(found) == [(8.0, 8.0), (9.0, 9.0)]


def held():
    """[kB] The memory of this process, and how many files it has open."""
    gc.collect()
    size = int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() // 1024
    return size, sum(1 for _ in Path("/proc/self/fd").iterdir())


def grown(*, open_again):
    """[kB] By how much this process grows in 2000 runs, and by how many open files."""
    made = load("static", Options())

    def run(simulation, times):
        for number in range(times):
            if open_again:
                with Simulation(made.system, h=made.h, until=0.2) as each:
                    each.step()
            else:
                simulation.reset({"plant.m": 1500.0 + number})
                simulation.step()
                simulation.step()

    with Simulation(made.system, h=made.h, until=0.2) as simulation:
        run(simulation, 200)
        before, files = held()
        run(simulation, 2000)
        after, files_after = held()
    return after - before, files_after - files


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="only Linux tells")
@pytest.mark.parametrize("open_again", [False, True], ids=["resets", "opens"])
def test_thousands_of_runs_in_one_process_take_no_more_memory_and_files(built_fmus, open_again):
    """In a process of its own: one that has run other tests grows and shrinks for other reasons."""
    code = f"from tests.orchestrator.stepping.test_reset import grown; print(*grown(open_again={open_again}))"
    root = Path(__file__).parents[3]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, check=True, capture_output=True, text=True)
    size, files = map(int, done.stdout.split())
    assert files == 0
    assert size < 4000
