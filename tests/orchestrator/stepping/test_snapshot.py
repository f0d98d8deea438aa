"""What follows a snapshot is what would have been, bit by bit: in the same simulation, in another, in another process.

Shows `state_keeper.py`, `fmus/units/fmu_state.py` and `state_bytes.py` too.
"""

from __future__ import annotations

import gc
import json
import re
import subprocess
import sys
import zipfile
from typing import final

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from components.interfaces.block import Block, block
from components.interfaces.problem import RequestError
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from fmus.units.fmu_state import FmuState
from fmus.units.fmu_unit import FmuUnit
from fmus.units.state_bytes import joined, parted
from fmus.units.unit import UnitError
from orchestrator import Fmu, Options, Simulation, SimulationError, Snapshot, System, load
from orchestrator.scenario import scenario_file
from orchestrator.system.experiment import Algorithm
from orchestrator.system.source import block_source
from tests.fmus.reference_fmus import reference_fmu
from tests.orchestrator.blocks import ANY, Gain, In, Out, Signal, Sum
from tests.orchestrator.exchange.passport.measured_fmus import lag
from tests.orchestrator.foreign import right_handed_mapping
from tests.orchestrator.stepping.test_native_stepper import random_systems


def assert_goes_on(make, tick, path=None):
    """Go to a tick, save, run on, go back, run on; likewise in a fork, and in a simulation that reads a file."""
    with make() as simulation:
        while simulation.tick < tick and not simulation.is_over:
            simulation.step()
        tick = simulation.tick
        snapshot = simulation.save()
        assert (snapshot.tick, snapshot.time) == (tick, simulation.time)
        if path is not None:
            snapshot.write(path)
        with simulation.fork() as fork:
            forked = finished(fork)
        expected = finished(simulation)
        simulation.restore(snapshot)
        assert simulation.tick == tick
        assert_same(finished(simulation), expected)
        remarks = simulation.remarks
    assert_same(forked, expected, tick)
    if path is not None:
        with make() as other:
            other.restore(Snapshot.read(path))
            assert_same(finished(other), expected, tick)
    return remarks


def finished(simulation):
    simulation.run()
    return simulation.columns()


def assert_same(found, expected, first=0):
    """The same rows; of a replay all, else those from a first tick on."""
    first = len(expected["time"]) - len(found["time"]) if len(found["time"]) < len(expected["time"]) else 0
    for name, column in expected.items():
        np.testing.assert_array_equal(found[name], column[first:], err_msg=name)


@pytest.mark.parametrize("name", scenario_file.names())
def test_every_scenario_goes_on_as_it_would_have(name, built_fmus, tmp_path):
    scenario = load(name, Options(mode=Version.FMI3, stop_time=6.0))
    tick = int(np.random.default_rng(len(name)).integers(0, 60))
    assert_goes_on(
        lambda: Simulation(scenario.system, h=scenario.h, until=scenario.until, algorithm=scenario.algorithm),
        tick,
        tmp_path / "s.npz",
    )


@pytest.mark.parametrize("mode", [*WRITTEN_VERSIONS, "blocks"], ids=str)
@pytest.mark.parametrize("algorithm", Algorithm)
def test_every_kind_of_unit_under_every_algorithm(mode, algorithm, built_fmus, tmp_path):
    system = load("static", Options(mode=mode)).system
    for tick in (-1, 0, 42):
        remarks = assert_goes_on(
            lambda: Simulation(system, h=0.1, until=8.0, algorithm=algorithm), tick, tmp_path / "s.npz"
        )
        assert not remarks


@pytest.mark.slow
@given(case=random_systems(), tick=st.integers(0, 20))
@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
def test_random_systems_go_on_as_they_would_have(case, tick):
    system, experiment = case
    experiment["until"] += experiment["start"]
    if experiment["record"] != {"*": 1}:
        experiment["record"] = {"*": 1}
    try:
        finished(Simulation(system, **experiment))
    except (RequestError, SimulationError):
        return  # a loop that cannot be solved
    assert_goes_on(lambda: Simulation(system, **experiment), tick)


@pytest.mark.parametrize(
    ("name", "interface"),
    [("bouncing_ball", "CoSimulation"), ("stair", "CoSimulation"), ("feedthrough", "CoSimulation")],
)
def test_fmus_of_others_that_save_no_state_run_again_from_the_start(name, interface, tmp_path):
    system = System({"m": Fmu(reference_fmu(name, Version.FMI3, interface))}, {}, held=held_of(name, interface))
    remarks = assert_goes_on(lambda: Simulation(system, h=0.1, until=1.5), 7, tmp_path / "s.npz")
    if Fmu(reference_fmu(name, Version.FMI3, interface)).interface.rolls_back:
        assert "running again" not in " ".join(remarks)
    else:
        assert "it went back to 0.7 s by running again from the start: `m` saves no state" in remarks


def held_of(name, interface):
    inputs = Fmu(reference_fmu(name, Version.FMI3, interface)).interface.inputs
    starts = Fmu(reference_fmu(name, Version.FMI3, interface)).interface.starts
    return {f"m.{v.name}": starts[v.name] for v in inputs if v.name in starts}


@pytest.mark.parametrize("capable", ['canGetAndSetFMUstate="true" canSerializeFMUstate="true"', ""])
@pytest.mark.parametrize("isolated", [False, True])
def test_with_a_state_or_without_here_or_in_a_process(capable, isolated, tmp_path):
    fmu = Fmu(lag(tmp_path, capable=capable))
    fmu = fmu.in_own_process(60.0) if isolated else fmu
    system = System({"m": fmu}, {}, held={"m.u": 1.0})
    remarks = assert_goes_on(lambda: Simulation(system, h=0.1, until=2.0), 7, tmp_path / "s.npz")
    assert bool(remarks) is not bool(capable)


def test_one_that_saves_its_state_and_cannot_write_it_forks_by_running_again(tmp_path):
    system = System(
        {"m": Fmu(lag(tmp_path, capable='canGetAndSetFMUstate="true"'))},
        {},
        held={"m.u": 1.0},
    )
    assert_goes_on(lambda: Simulation(system, h=0.1, until=2.0), 7)


def test_a_mapped_fmu_goes_back_with_what_is_around_it(built_fmus, tmp_path):
    scenario = load("static", Options(replacements={"plant": str(right_handed_mapping(tmp_path))}))
    assert_goes_on(lambda: Simulation(scenario.system, h=0.1, until=6.0), 23, tmp_path / "s.npz")


def test_what_was_written_is_part_of_it(built_fmus, tmp_path):
    system = load("static", Options(mode=Version.FMI3)).system

    def make():
        simulation = Simulation(system, h=0.1, until=4.0)
        simulation.reset({"plant.m": 1500.0})
        while simulation.tick < 10:
            simulation.step()
        simulation.write("plant.actuation.delta_f", 0.01)
        simulation.write("plant.mu", 0.4)
        return simulation

    assert_goes_on(make, 20)
    with make() as simulation:
        simulation.save().write(tmp_path / "s.npz")
        simulation.release("plant.actuation.delta_f")
        changed = finished(simulation)
        simulation.restore(Snapshot.read(tmp_path / "s.npz"))
        held = finished(simulation)
    assert set(held["plant.actuation.delta_f"][11:]) == {0.01}
    assert not np.array_equal(changed["plant.state.y"], held["plant.state.y"])


SECOND = """
import sys
from fmus import Version
from orchestrator import Options, Simulation, Snapshot, load
simulation = Simulation(load("static", Options(mode=Version(int(sys.argv[2])))).system, h=0.1, until=8.0)
simulation.restore(Snapshot.read(sys.argv[1]))
simulation.run()
simulation.frame().to_parquet(sys.argv[3])
"""


@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=str)
def test_another_process_goes_on(version, built_fmus, tmp_path):
    import pandas as pd  # noqa: PLC0415

    files = [str(tmp_path / "s.npz"), str(int(version)), str(tmp_path / "rows.parquet")]
    with Simulation(load("static", Options(mode=version)).system, h=0.1, until=8.0) as simulation:
        for _ in range(31):
            simulation.step()
        simulation.save().write(files[0])
        subprocess.run([sys.executable, "-c", SECOND, *files], check=True)
        expected = finished(simulation)
    found = pd.read_parquet(files[2])
    assert len(found) == 81 - 30
    assert_same({name: found[name].to_numpy() for name in found}, expected)


def test_a_snapshot_is_of_its_system_only(built_fmus):
    static, idle = (load(name, Options(mode="blocks")).system for name in ("static", "idle"))
    with Simulation(static, h=0.1, until=1.0) as one, Simulation(idle, h=0.1, until=1.0) as other:
        one.step()
        with pytest.raises(RequestError) as error:
            other.restore(one.save())
    assert str(error.value) == (
        "snapshot: found one of another system; valid: one of the same system: units, FMUs, connections, step and"
        " algorithm. Make one with `save`."
    )


def damaged(tmp_path, change):
    with Simulation(load("static", Options(mode="blocks")).system, h=0.1, until=1.0) as simulation:
        simulation.step()
        simulation.save().write(tmp_path / "s.npz")
    content = (tmp_path / "s.npz").read_bytes()
    (tmp_path / "s.npz").write_bytes(change(content))
    with pytest.raises(RequestError) as error:
        Snapshot.read(tmp_path / "s.npz")
    return str(error.value)


@pytest.mark.parametrize("change", [lambda c: c[: len(c) // 2], lambda c: b"", lambda c: b"x" * 100])
def test_a_damaged_file_is_refused(change, built_fmus, tmp_path):
    text = damaged(tmp_path, change)
    assert text.startswith(f"{tmp_path / 's.npz'}: found a")
    assert text.endswith("valid: a snapshot that `Snapshot.write` has written. Save another one.")


def test_another_file_and_none_are_refused(tmp_path):
    np.savez(tmp_path / "other.npz", about=np.frombuffer(b'{"format": 7}', dtype=np.uint8))
    for name, found in (("other.npz", "the form 7"), ("none.npz", "no such file")):
        with pytest.raises(RequestError, match=found):
            Snapshot.read(tmp_path / name)
    with zipfile.ZipFile(tmp_path / "zip.npz", "w") as archive:
        archive.writestr("about.npy", b"no array")
    with pytest.raises(RequestError, match="a snapshot that"):
        Snapshot.read(tmp_path / "zip.npz")


def test_a_file_that_cannot_be_written_is_told(built_fmus, tmp_path):
    with Simulation(load("idle", Options(mode="blocks")).system, h=0.1, until=1.0) as simulation:
        simulation.step()
        with pytest.raises(RequestError, match="valid: a file that can be written"):
            simulation.save().write(tmp_path / "no folder" / "s.npz")


def test_a_unit_that_shows_other_values_in_each_run_cannot_go_back(tmp_path):
    counting = "static int runs;\n#define ON_RESET begin(i); runs++;\n#define SHOWN i->x + runs"
    fmu = Fmu(lag(tmp_path, counting, capable=""))
    with Simulation(System({"m": fmu}, {}, held={"m.u": 1.0}), h=0.1, until=2.0) as simulation:
        for _ in range(5):
            simulation.step()
        snapshot = simulation.save()
        with pytest.raises(RequestError) as error:
            simulation.restore(snapshot)
    assert "m.y: found 1.5" in str(error.value)
    assert str(error.value).endswith("`m` cannot go back.")


def test_a_snapshot_gives_its_memory_back(built_fmus, monkeypatch):
    balance = [0]
    save, forget = FmuState.save, FmuState.forget
    monkeypatch.setattr(FmuState, "save", lambda self: (balance.__setitem__(0, balance[0] + 1), save(self))[1])
    monkeypatch.setattr(FmuState, "forget", lambda *a: (balance.__setitem__(0, balance[0] - 1), forget(*a))[1])
    with Simulation(load("static", Options(mode=Version.FMI2)).system, h=0.1, until=4.0) as simulation:
        simulation.step()
        for _ in range(20):
            kept = simulation.save()
        gc.collect()
        assert balance[0] <= 6  # that of the last snapshot, and of one that nobody has any more
        simulation.restore(kept)
    assert balance == [0]
    with pytest.raises(RequestError, match="closed"):
        simulation.restore(kept)


@given(parts=st.lists(st.binary(max_size=40), max_size=5), cut=st.integers(1, 8))
def test_parts_are_joined_and_parted(parts, cut):
    content = joined(parts)
    assert parted(content, len(parts)) == parts
    for other in (content[:-cut], content + b"\0" * cut) if parts else ():
        with pytest.raises(ValueError, match="parts in"):
            parted(other, len(parts))


def test_a_write_that_came_later_is_undone_and_one_that_came_before_is_done_again(built_fmus):
    system = load("static", Options(mode=Version.FMI3)).system
    with Simulation(system, h=0.1, until=3.0) as simulation:
        expected = finished(simulation)
    for native in (True, False):
        with Simulation(system, h=0.1, until=3.0, native=native) as simulation:
            for _ in range(10):
                simulation.step()
            free = simulation.save()
            simulation.write("plant.actuation.delta_f", 0.05)
            for _ in range(5):
                simulation.step()
            held = simulation.save()
            steered = finished(simulation)
            simulation.restore(free)
            assert_same(finished(simulation), expected)
            simulation.restore(held)
            found = finished(simulation)
            assert found["time"][0] == 14 * 0.1  # the rows before were of the other future
            assert_same(found, steered)


def test_garbage_of_simulations_and_snapshots_that_know_each_other(built_fmus):
    """Weak references are cleared before anything is finalised: no state may be released in a closed FMU."""
    system = load("static", Options(mode=Version.FMI3)).system

    class Node:
        pass

    for _ in range(3):
        node = Node()
        node.itself, node.simulation = node, Simulation(system, h=0.1, until=3.0)
        node.simulation.step()
        node.snapshot = node.simulation.save()
        del node
        gc.collect()


def test_infinite_values_end_the_run_after_going_back_too():
    system = System(
        {"s": block_source(Grows()), "g": block_source(Gain(k=1.0))}, {"g.a": "s.b"}, held={"s.a.value": 0.0}
    )
    for native in (True, False):
        with Simulation(system, h=1.0, until=3000.0, native=native) as simulation:
            for tick in (-1, 0, 3):
                while simulation.tick < tick:
                    simulation.step()
                snapshot = simulation.save()
                ends = []
                for _ in range(2):
                    with pytest.raises(SimulationError) as error:
                        simulation.run()
                    ends.append((simulation.tick, str(error.value)))
                    simulation.restore(snapshot)
                assert ends[0] == ends[1]
                assert "is inf" in ends[0][1]


@final
@block(ANY)
class Grows(Block[In, Signal, Out]):
    """Doubles its state until it is infinite."""

    def start(self):
        return Signal(value=1e200)

    def output(self, x, u):
        return Out(b=x)

    def step(self, x, u, h):
        return Signal(value=x.value * 1e20)


def test_a_later_stop_time_is_needed_for_a_later_tick(built_fmus):
    system = load("static", Options(mode="blocks")).system
    with Simulation(system, h=0.1, until=3.0) as one, Simulation(system, h=0.1, until=1.0) as other:
        while one.tick < 24:
            one.step()
        with pytest.raises(RequestError) as error:
            other.restore(one.save())
        assert str(error.value) == (
            "snapshot: found one of the tick 24, at 2.4 s; valid: one of a tick up to 10. Set a later stop time."
        )
        assert other.tick == -1
        other.run()  # nothing has been changed


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda about, arrays: about.update(tick=-2900), "one of the tick -2900"),
        (lambda about, arrays: about.update(changes=[[1, "plant.nothing", 1.0]]), "no input or tunable parameter"),
        (lambda about, arrays: about.update(changes=[[1, "plant.mu", "x"]]), "a value that it cannot take"),
        (lambda about, arrays: about.update(changes=[[7, "plant.mu", 0.5]]), "the tick 7"),
        (lambda about, arrays: about.update(held=[["a", "b"]]), "inputs that there are not"),
        (lambda about, arrays: about.update(tick="x"), "a damaged file"),
        (lambda about, arrays: about.update(ended=[1]), "a damaged file"),
        (lambda about, arrays: arrays.update(state_plant=arrays["state_plant"][:40]), "a damaged state of `plant`"),
        (
            lambda about, arrays: arrays.update(state_plant=bytes_of([b"12345678"] * 4 + [b"\0"])),
            "a damaged state of `plant`",
        ),
        (lambda about, arrays: arrays.update(column_Float64=arrays["column_Float64"][:3]), "one of another system"),
        (lambda about, arrays: arrays.pop("column_Float64"), "a damaged file"),
    ],
)
def test_a_file_that_somebody_has_changed_is_refused_and_changes_nothing(change, text, built_fmus, tmp_path):
    system = load("static", Options(mode="blocks")).system
    with Simulation(system, h=0.1, until=2.0) as simulation:
        simulation.step()
        simulation.save().write(tmp_path / "s.npz")
        expected = finished(simulation)
    with np.load(tmp_path / "s.npz") as file:
        arrays = dict(file)
    about = json.loads(arrays["about"].tobytes())
    change(about, arrays)
    arrays["about"] = np.frombuffer(json.dumps(about).encode(), dtype=np.uint8)
    np.savez(tmp_path / "s.npz", **arrays)
    with Simulation(system, h=0.1, until=2.0) as simulation:
        with pytest.raises(RequestError, match=re.escape(text)):
            simulation.restore(Snapshot.read(tmp_path / "s.npz"))
        assert_same(finished(simulation), expected)


def bytes_of(parts):
    return np.frombuffer(joined(parts), dtype=np.uint8)


def test_rows_of_an_undone_future_do_not_come_back(monkeypatch):
    units = {"s": block_source(Sum()), "q": block_source(Sum())}
    with Simulation(System(units, {"s.a": "q.b"}, held={"q.a.value": 0.0}), h=0.1, until=3.0) as simulation:
        for _ in range(5):
            simulation.step()
        snapshot = simulation.save()
        simulation.run()
        simulation.restore(snapshot)

        def fails(*_):
            raise UnitError("s", "x", ())

        monkeypatch.setattr(simulation._running.by_name["s"], "step", fails)
        with pytest.raises(SimulationError):
            simulation.step()
        assert len(simulation.columns()["time"]) == 5


def test_parameters_are_those_of_the_snapshot_afterwards(built_fmus):
    system = load("static", Options(mode=Version.FMI3)).system
    mass = system.units["plant"].parameters["m"]
    with Simulation(system, h=0.1, until=3.0) as one:
        one.reset({"plant.m": 1.3 * mass})
        for _ in range(5):
            one.step()
        with one.fork() as other:
            speeds = []
            for simulation in (one, other):
                simulation.write("plant.m", mass)
                simulation.step()
                simulation.release("plant.m")
                simulation.run()
                speeds.append(simulation.read("plant.state.v_x"))
    assert speeds[0] == speeds[1]


def test_a_file_is_whole_or_what_it_was(built_fmus, tmp_path):
    system = load("static", Options(mode=Version.FMI3)).system
    with Simulation(system, h=0.1, until=2.0) as simulation:
        simulation.step()
        simulation.save().write(tmp_path / "s.npz")
        before = (tmp_path / "s.npz").read_bytes()
        snapshot = simulation.save()
    with pytest.raises(RequestError, match="found a snapshot of a simulation that is closed"):
        snapshot.write(tmp_path / "s.npz")
    assert (tmp_path / "s.npz").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["s.npz"]


def test_a_fork_that_fails_leaves_nothing_open(tmp_path, monkeypatch):
    fmu = Fmu(lag(tmp_path))
    closed = []
    close = FmuUnit.close
    monkeypatch.setattr(FmuUnit, "close", lambda unit: (closed.append(unit.name), close(unit)))
    with Simulation(System({"m": fmu}, {}, held={"m.u": 1.0}), h=0.1, until=2.0) as simulation:
        simulation.step()
        monkeypatch.setattr(FmuState, "serialized", lambda *_: b"x")
        monkeypatch.setattr(FmuState, "deserialized", lambda *_: (_ for _ in ()).throw(UnitError("m", "no", ())))
        with pytest.raises(SimulationError):
            simulation.fork()
        assert closed == ["m"]


def test_after_ctrl_c_in_the_midst_of_a_step_only_reset_and_restore_go_on():
    units = {"s": block_source(Sum()), "q": block_source(Sum())}
    for native in (True, False):
        made = System(units, {"s.a": "q.b"}, held={"q.a.value": 1.0})
        with Simulation(made, h=0.1, until=3.0, native=native) as simulation:
            for _ in range(5):
                simulation.step()
            snapshot = simulation.save()
            unit = simulation._running.by_name["q"]
            step = unit.step
            unit.step = lambda *_: (_ for _ in ()).throw(KeyboardInterrupt)
            with pytest.raises(KeyboardInterrupt):
                simulation.run()
            unit.step = step
            for action in (simulation.step, simulation.run, simulation.save):
                with pytest.raises(RequestError) as error:
                    action()
                assert str(error.value) == (
                    "simulation: found a step that was interrupted after 0.4 s; valid: one whose last step is complete."
                    " Call `reset`, or `restore`."
                )
            simulation.restore(snapshot)
            assert (
                finished(simulation)["s.b.value"].tolist()
                == finished(Simulation(made, h=0.1, until=3.0))["s.b.value"].tolist()
            )


def test_going_back_again_and_again_does_not_become_dearer(built_fmus):
    static = load("static")
    with Simulation(static.system, h=static.h, until=static.until) as simulation:
        simulation.step()
        for _ in range(100):
            snapshot = simulation.save()
            simulation.step()
            simulation.restore(snapshot)
        assert len(simulation.save().past) <= 3
