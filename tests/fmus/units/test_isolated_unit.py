"""FMUs in processes of their own: the same numbers as in this one, and a message where they die or hang."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type, zeros
from fmus.toolchain.scratch import scratch_root
from fmus.toolchain.version import Version
from fmus.units.unit import carry_out, widths
from orchestrator import load
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description3, library, pack
from tests.fmus.reading.test_declared_variables import VALUES, echo3, held
from tests.left_behind import left_in
from tests.waiting import wait_until

pytestmark = pytest.mark.foreign  # processes are what these tests are about

Y = ['<Float64 name="y" valueReference="101" causality="output"/>']
OUTPUT = ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>']


@pytest.fixture(scope="module")
def echo(tmp_path_factory):
    return echo3(tmp_path_factory)


def made(folder, source):
    return pack(folder / "m.fmu", Version.FMI3, description3(Y, OUTPUT), library(folder, Version.FMI3, source))


def failing(path, patience=30.0):
    """What ends a run of 10 steps, and how many rows are left."""
    system = System({"m": Fmu(path, isolated=patience)}, {})
    with Simulation(system, h=0.1, until=1.0) as simulation:
        with pytest.raises(SimulationError) as error:
            simulation.run()
        return str(error.value), len(simulation.frame())


def test_values_of_every_type_cross_the_border(echo):
    units = {"a": Fmu(echo, {"n": 3}, isolated=30.0), "b": Fmu(echo, {"n": 3})}
    system = System(units, {"b.u": "a.y"}, held=held(n=3))
    with Simulation(system, h=0.1, until=0.3) as simulation:
        for tick in simulation:
            if tick.tick == 1:
                simulation.write("a.u.Int16", 12)
                simulation.write("a.u.String", "other")
        expected = held("b", n=3) | {"b.u.Int16": 12, "b.u.String": "other"}
        for path, value in expected.items():
            assert np.array_equal(simulation.read(path.replace(".u.", ".y.")), value), path
    assert len(VALUES) == 14


@pytest.mark.parametrize("version", [2, 3])
def test_a_system_of_isolated_fmus_runs_as_in_one_process(built_fmus, version):
    def run(patience):
        files = {n: built_fmus / f"fmi{version}" / f"{n}.fmu" for n in ("bicycle", "stanley", "ramp_traffic")}
        units = {
            "plant": Fmu(files["bicycle"], isolated=patience),
            "controller": Fmu(files["stanley"], isolated=patience),
            "traffic": Fmu(files["ramp_traffic"]),
        }
        wiring = {"plant.actuation": "controller.actuation", "traffic.ego": "plant.state"}
        wiring |= {"controller.ego": "plant.state", "controller.obstacles": "traffic.obstacles"}
        return simulate(System(units, wiring), h=0.1, until=2.0)

    assert run(30.0).equals(run(None))


def test_a_process_that_dies_ends_the_run_with_all_rows(tmp_path):
    path = made(tmp_path, '#define STATUS (t > 0.25 ? *(volatile int *)8 : 0)\n#include "echo3.c"')
    assert failing(path) == ("tick 3 (t = 0.3 s), unit `m`: its process died in `fmi3DoStep` (SIGSEGV)", 4)


def test_a_process_that_ends_itself_is_told_too(tmp_path):
    path = made(tmp_path, '#define STATUS (t > 0.25 ? (exit(7), 0) : 0)\n#include "echo3.c"')
    assert failing(path) == ("tick 3 (t = 0.3 s), unit `m`: its process died in `fmi3DoStep` (exit code 7)", 4)


def test_a_process_that_hangs_is_ended(tmp_path):
    hangs = "t > 0.25 ? sleep(100000) : 0"  # this test would never end if it were waited for
    path = made(tmp_path, f'#include <unistd.h>\n#define STATUS ({hangs})\n#include "echo3.c"')
    found = "tick 3 (t = 0.3 s), unit `m`: no answer to `fmi3DoStep` within 0.3 s; its process has been ended"
    assert failing(path, 0.3) == (found, 4)


def test_errors_come_with_what_the_fmu_says(tmp_path):
    path = made(tmp_path, '#define STATUS (t > 0.25 ? fmi3Error : 0)\n#include "echo3.c"')
    assert failing(path) == ("tick 3 (t = 0.3 s), unit `m`: `fmi3DoStep` returned an error", 4)


def test_what_cannot_be_instantiated_is_refused_as_in_this_process(tmp_path):
    text = description3(Y, OUTPUT, guid="other")
    path = pack(tmp_path / "m.fmu", Version.FMI3, text, library(tmp_path, Version.FMI3, '#include "echo3.c"'))
    with pytest.raises(RequestError) as error:
        simulate(System({"m": Fmu(path, isolated=30.0)}, {}), h=0.1, until=0.1)
    assert 'refuses to make an instance (the token is "g")' in str(error.value)


def test_states_are_told_apart_after_one_of_them_was_forgotten(built_fmus):
    unit = Fmu(built_fmus / "fmi3" / "bicycle.fmu", isolated=30.0).open("m")
    columns = [{k: zeros(k, n) for k, n in widths(v).items()} for v in (unit.interface.inputs, unit.interface.outputs)]
    unit.bind(*columns)
    unit.enter_initialization({})
    unit.exit_initialization()

    def position():
        carry_out(unit.getters())
        return columns[1][Type.FLOAT64][0]

    seen = {}
    for tick in range(4):
        seen[unit.state.save()] = position()
        if tick == 2:
            unit.state.forget(min(seen))
            del seen[min(seen)]
        unit.step(0.1 * tick, 0.1)
    for state, x in seen.items():
        unit.state.restore(state)
        assert position() == x
    assert len(set(seen.values())) == 3
    unit.close()


def open_files():
    return {p.name for p in Path("/proc/self/fd").iterdir()}


def test_nothing_stays_behind(tmp_path, monkeypatch):
    place = tmp_path / "place"
    place.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(place))
    scratch_root()  # with its lock it stays as long as this process
    before = open_files()
    path = made(tmp_path, '#define STATUS (t > 0.25 ? *(volatile int *)8 : 0)\n#include "echo3.c"')
    failing(path)
    assert left_in(place) == []
    assert len(open_files() - before) <= 1


def test_processes_share_the_files_in_the_cache_until_an_fmu_changes_them(tmp_path, monkeypatch):
    cache = tmp_path / "cache"
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    headers = "#define _GNU_SOURCE\n#include <dlfcn.h>\n#include <stdio.h>\n#include <string.h>"
    writes = """
static int more(void *own) {
    Dl_info found; char name[4096]; FILE *file;
    if (!dladdr(own, &found)) return 3;
    snprintf(name, sizeof name, "%s.txt", found.dli_fname);
    if (!(file = fopen(name, "w"))) return 3;
    return fclose(file);
}"""
    source = f'{headers}\n{writes}\n#define STATUS more((void *)more)\n#include "echo3.c"'
    system = System({"m": Fmu(made(tmp_path, source))}, {})
    told = []
    for _ in range(2):
        with Simulation(system, h=0.1, until=0.1) as simulation:
            simulation.run()
            told.append(simulation.remarks)
    (kept,) = (path for path in (cache / "macrostep" / "unpacked").iterdir() if path.is_dir())
    assert list(kept.rglob("*.txt"))
    assert told == [[], [f"unit `m`: its files in the cache had changed, and were unpacked again ({kept})"]]


@pytest.mark.parametrize("version", [2, 3])
def test_a_reset_forgets_what_was_said(built_fmus, version):
    file = built_fmus / f"fmi{version}" / "bicycle.fmu"
    unit = Fmu(file, load("static").system.units["plant"].parameters, isolated=30.0).open("plant")
    unit.messages.append("a message")
    unit.warned()
    unit.reset()
    assert (len(unit.messages), unit.warnings) == (0, 0)
    unit.close()


HARMLESS = {
    "folder": 'chdir("/")',
    "permissions": "umask(0777)",
    "streams": "close(0), close(1), close(2)",
    "locale": 'setlocale(LC_ALL, "C.UTF-8")',
    "rounding": "fesetround(FE_UPWARD)",
    "traps": "feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW)",
    "signals": "signal(SIGINT, SIG_IGN), signal(SIGPIPE, SIG_DFL), signal(SIGCHLD, SIG_IGN)",
    "interrupt": "raise(SIGCONT)",
    "garbage": 'everywhere("\\x80\\x04K\\x07.")',
    "prints": 'printf("%s", "no answer"), fflush(stdout)',
}
FATAL = {
    "ends": ("exit(0)", "its process died in `fmi3DoStep` (exit code 0)"),
    "aborts": ("abort()", "its process died in `fmi3DoStep` (SIGABRT)"),
    "killed": ("kill(getpid(), SIGKILL)", "its process died in `fmi3DoStep` (SIGKILL)"),
    "divides": ("feenableexcept(FE_DIVBYZERO), zero = 1 / zero", "its process died in `fmi3DoStep` (SIGFPE)"),
    "stops": ("raise(SIGSTOP)", "no answer to `fmi3DoStep` within 0.5 s; its process has been ended"),
    "half an answer": (
        'everywhere("\\x7f\\xff\\xff\\xff"), sleep(100000)',
        "no answer to `fmi3DoStep` within 0.5 s; its process has been ended",
    ),
}
DEED = """
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
static volatile double zero;
static void everywhere(const char *text) {
    for (int f = 3; f < 1024; f++) {
        if (fcntl(f, F_GETFL) < 0) continue;
        fcntl(f, F_SETFL, fcntl(f, F_GETFL) | O_NONBLOCK);
        write(f, text, strlen(text));
    }
}
"""


@pytest.mark.parametrize("pipes", [False, True], ids=["shared", "pipes"])
@pytest.mark.parametrize("deed", HARMLESS.values(), ids=HARMLESS)
def test_what_an_fmu_does_to_its_process_is_not_done_to_the_run(in_tmp_path, monkeypatch, deed, pipes):
    if pipes:
        monkeypatch.setattr("fmus.units.unit_process.counters_work", lambda: False)
    path = made(in_tmp_path, f'{DEED}\n#define STATUS (t > 0.25 ? ({deed}, 0) : 0)\n#include "echo3.c"')
    handler = signal.getsignal(signal.SIGINT)
    with Simulation(System({"m": Fmu(path)}, {}), h=0.1, until=1.0) as simulation:
        simulation.run()
        assert len(simulation.frame()) == 11
    assert Path.cwd() == in_tmp_path
    assert signal.getsignal(signal.SIGINT) is handler


@pytest.mark.parametrize(("deed", "found"), FATAL.values(), ids=FATAL)
def test_what_ends_the_process_of_an_fmu_ends_the_run_in_order(tmp_path, deed, found):
    path = made(tmp_path, f'{DEED}\n#define STATUS (t > 0.25 ? ({deed}, 0) : 0)\n#include "echo3.c"')
    assert failing(path, 0.5) == (f"tick 3 (t = 0.3 s), unit `m`: {found}", 4)


def test_the_numbers_are_those_of_messages(built_fmus, monkeypatch):
    def rows():
        plant = Fmu(built_fmus / "fmi3" / "bicycle.fmu", isolated=30.0)
        held = {"plant.actuation.delta_f": 0.1, "plant.actuation.T_r": 20.0}
        return simulate(System({"plant": plant}, {}, held), h=0.1, until=2.0)

    shared = rows()
    monkeypatch.setattr("fmus.units.unit_process.counters_work", lambda: False)
    assert shared.equals(rows())


def test_what_an_fmu_has_started_ends_with_it(tmp_path):
    deed = (
        'fork() == 0 ? (pid = fopen(getenv("THEIRS"), "w"), fprintf(pid, "%d", getpid()), fclose(pid), sleep(1000)) : 0'
    )
    source = f'{DEED}\nstatic FILE *pid;\n#define STATUS (t < 0.05 ? ({deed}, 0) : 0)\n#include "echo3.c"'
    path, theirs = made(tmp_path, source), tmp_path / "theirs"
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("THEIRS", str(theirs))
        assert len(simulate(System({"m": Fmu(path)}, {}), h=0.1, until=0.5)) == 6
    wait_until(lambda: not _runs(int(theirs.read_text())))


def _runs(process: int) -> bool:
    """Whether a process has not ended; one that nobody has waited for yet has."""
    stat = Path(f"/proc/{process}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"


SCRIPT = """
import sys
from orchestrator.system.source import Fmu
Fmu(sys.argv[1], isolated=1000.0).open("m")
"""


def test_a_process_does_not_outlive_the_one_that_has_started_it(tmp_path):
    path = made(tmp_path, f'{DEED}\n#define EXTRA for (;;) sleep(1);\n#include "echo3.c"')
    with subprocess.Popen([sys.executable, "-c", SCRIPT, str(path)]) as parent:
        of_parent = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
        children = wait_until(lambda: [int(child) for child in of_parent.read_text().split()])
        time.sleep(2.0)  # it hangs in the FMU by now
        parent.kill()
    wait_until(lambda: not any(map(_runs, children)))
