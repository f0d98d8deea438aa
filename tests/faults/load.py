"""Many at once, and many one after another: each result is whole, and nothing gathers."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas as pd

from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.version import Version
from tests.faults.commands import LASTS, Started, is_whole
from tests.faults.scoring import fault
from tests.fmus.foreign import description3, library, pack
from tests.orchestrator.large import ssp_of_units

GROUP = "many at once, scale"
SHORT = ("run", "static", "--blocks", "--stop-time", "1")
SAME = ("signals.parquet", "figures/trajectory.png")
"""What is the same to the bit in every run of a scenario."""


def hashes(run):
    return [sha256((run / name).read_bytes()).hexdigest() for name in SAME]


def all_whole(folders):
    """Check that all runs are whole and alike."""
    for each in folders:
        is_whole(each, "finished")
    assert len({tuple(hashes(each)) for each in folders}) == 1


def own_folders(number):
    def check(folder, _):
        started = [Started(folder, *SHORT, "--out", f"r{k}") for k in range(number)]
        assert [each.end()[0] for each in started] == [0] * number
        all_whole([folder / f"r{k}" for k in range(number)])

    return check


fault(GROUP, "3 runs at once")(own_folders(3))
fault(GROUP, "8 runs at once", short=False)(own_folders(8))


@fault(GROUP, "8 runs at once without --out", short=False)
def automatic_folders(folder, _):
    started = [Started(folder, *SHORT) for _ in range(8)]
    assert [each.end()[0] for each in started] == [0] * 8
    runs = sorted((folder / "runs").iterdir())
    assert len(runs) == 8
    all_whole(runs)


@fault(GROUP, "4 runs at once into one --out", short=False)
def one_folder(folder, _):
    started = [Started(folder, *SHORT, "--out", "r") for _ in range(4)]
    ended = [each.end() for each in started]
    assert {code for code, _ in ended} <= {0, 2}, ended
    assert any(code == 0 for code, _ in ended), ended
    is_whole(folder / "r", "finished")


@fault(GROUP, "8 checks of one FMU at once", short=False)
def checks(folder, _):
    foreign(folder)
    started = [Started(folder, "check", "m.fmu") for _ in range(8)]
    assert [each.end()[0] for each in started] == [0] * 8


def foreign(folder, variables=()):
    """An FMU of another maker, with as many outputs more as wanted."""
    y = '<Float64 name="y" valueReference="101" causality="output"/>'
    built = library(folder / "made", Version.FMI3, '#include "echo3.c"')
    structure = ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>']
    return pack(folder / "m.fmu", Version.FMI3, description3([y, *variables], structure), built)


MANY = """
import gc, json, os, shutil, sys
from pathlib import Path
from components.interfaces.progress import SILENT
from fmus.toolchain.scratch import scratch_root
from orchestrator import Options, Simulation, load
from orchestrator.execution import Execution, execute

scratch_root()  # it opens a file that stays open

def left():
    count = lambda name: len(os.listdir(f"/proc/self/{name}"))
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
    return [count("task"), count("fd"), len([*scratch_root().rglob("*")]), resident]

def stepped():
    made = load("static", Options(mode="blocks", stop_time=0.3))
    with Simulation(made.system, h=made.h, until=made.until) as simulation:
        simulation.run()

def executed():
    shutil.rmtree("r", ignore_errors=True)
    done = execute(load("static", Options(stop_time=0.1)), Path("r"), SILENT, Execution(figures=FIGURES))
    assert done.notes == (), done.notes

for k in range(WARM + NUMBER):
    ACTION()
    if k == WARM - 1:
        before = left()
after = left()
print(json.dumps([before, after]))
"""


def one_after_another(action, number, *, most, figures=False, first=20):
    """Do something many times in one process; after the `first` times it may not grow by more than `most` MiB."""

    def check(folder, _):
        words = {"ACTION": action, "NUMBER": str(number), "WARM": str(first), "FIGURES": str(figures)}
        script = MANY
        for word, meaning in words.items():
            script = script.replace(word, meaning)
        done = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        before, after = json.loads(done.stdout.splitlines()[-1])
        assert before[:3] == after[:3], (before, after)
        assert after[3] - before[3] < most, (before, after)

    return check


fault(GROUP, "50 simulations one after another in a process")(one_after_another("stepped", 50, most=20))
fault(GROUP, "6 runs one after another in a process")(one_after_another("executed", 6, most=60, first=4))
fault(GROUP, "1000 simulations one after another in a process", short=False)(
    one_after_another("stepped", 1000, most=20)
)
fault(GROUP, "1000 runs one after another in a process", short=False)(one_after_another("executed", 1000, most=60))
fault(GROUP, "100 runs with figures one after another in a process", short=False)(
    one_after_another("executed", 100, most=60, figures=True)
)


def peak_of(folder, *arguments):
    """Run the command to its end; the largest resident memory [MiB] of any of its processes."""
    run = Started(folder, *arguments)
    _, said = run.process.communicate()
    assert run.process.returncode == 0, said
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


@fault(GROUP, "a million ticks", short=False)
def a_million_ticks(folder, _):
    foreign(folder)
    own = ("run", "m.fmu", "--in-process", "--step", 0.001, "--record", "*")
    few = peak_of(folder, *own, "--stop-time", 10, "--out", "few")
    many = peak_of(folder, *own, "--stop-time", 1000, "--out", "many")
    assert len(pd.read_parquet(folder / "many" / "signals.parquet")) == 1_000_001
    assert many < few + 150, (few, many)


def units(number, *how):
    def check(folder, _):
        path = ssp_of_units(folder, number)
        code, said = Started(folder, "run", path, *how, "--stop-time", "0.3", "--step", "0.1", "--out", "r").end(900)
        assert code == 0, said
        is_whole(folder / "r", "finished")
        rows = pd.read_parquet(folder / "r" / "signals.parquet")
        assert {f"c{k}.y_u{i}" for k in range(number) for i in range(10)} <= {*rows.columns}
        assert np.isfinite(rows.to_numpy(dtype=float)).all()

    return check


fault(GROUP, "1000 units with 10 000 connections", short=False)(units(1000, "--in-process"))
fault(GROUP, "32 units in processes of their own", short=False)(units(32))
fault(GROUP, "6 units in processes of their own")(units(6))


def few_descriptors(most):
    def check(folder, _):
        foreign(folder)

        def limited():
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))

        run = Started(folder, "run", "m.fmu", "--stop-time", 1, "--step", 0.1, "--out", "r", preexec_fn=limited)
        in_words(run, folder)

    return check


def in_words(run, folder):
    """Check that a command either does all or says in words what is missing."""
    code, said = run.end()
    assert code in {0, 1, 2}, (code, said)
    if code == 0:
        is_whole(folder / "r", "finished")
    else:
        assert said.strip(), "it ends without a word"


for most in (64, 32, 20, 12):
    fault(GROUP, f"{most} descriptors", short=most == 32)(few_descriptors(most))

LIMIT = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <unistd.h>
static int left = -1;
static int refused(void) {
    if (left < 0) left = atoi(getenv("MOST_PROCESSES"));
    if (left == 0) { errno = EAGAIN; return 1; }
    left--;
    return 0;
}
pid_t fork(void) {
    static pid_t (*real)(void);
    if (!real) real = (pid_t (*)(void))dlsym(RTLD_NEXT, "fork");
    return refused() ? -1 : real();
}
pid_t vfork(void) { return fork(); }
"""


def few_processes(most):
    def check(folder, _):
        foreign(folder)
        made = folder / "limit.so"
        (folder / "limit.c").write_text(LIMIT)
        subprocess.run(
            [*required_compiler().command, "-shared", "-fPIC", folder / "limit.c", "-o", made, "-ldl"], check=True
        )
        environment = {**os.environ, "LD_PRELOAD": str(made), "MOST_PROCESSES": str(most)}
        run = Started(folder, "run", "m.fmu", "--stop-time", 1, "--step", 0.1, "--out", "r", env=environment)
        in_words(run, folder)

    return check


for most in range(4):
    fault(GROUP, f"each process can start {most} others", short=most == 1)(few_processes(most))


@fault(GROUP, "an FMU with 100 000 variables", short=False)
def many_variables(folder, _):
    more = [
        f'<Float64 name="p{k}" valueReference="{k + 1000}" causality="parameter" variability="fixed" start="1"/>'
        for k in range(100_000)
    ]
    foreign(folder, more)
    code, said = Started(folder, "run", "m.fmu", "--stop-time", 1, "--step", 0.1, "--out", "r").end()
    assert code == 0, said
    is_whole(Path(folder) / "r", "finished")


@fault(GROUP, "started in the background by a shell, where SIGINT is ignored", short=False)
def in_the_background(folder, _):
    def ignored():
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    run = Started(folder, *LASTS, "--out", "r", preexec_fn=ignored)
    run.wait_for("r/recording.rrd")
    os.killpg(run.process.pid, signal.SIGINT)
    assert run.end()[0] == 0
    is_whole(folder / "r", "finished")
    run = Started(folder, *LASTS, "--out", "s", preexec_fn=ignored)
    run.wait_for("s/recording.rrd")
    run.process.terminate()
    assert run.end()[0] == 130
    is_whole(folder / "s", "interrupted")
