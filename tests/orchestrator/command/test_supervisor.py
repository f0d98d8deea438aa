"""The process that outlives a run, and the signals that end it; shows `interruption.py` and `companions.py` too."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from fmus.toolchain.version import Version
from orchestrator.command.supervisor import _Told
from tests.fmus.foreign import description3, library, pack

COMMAND = Path(sys.executable).with_name("macrostep")
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="one process where there is no fork")


def model(folder, source):
    """An FMU whose steps do what the C text `STATUS` says."""
    headers = "#define _GNU_SOURCE\n#include <signal.h>\n#include <unistd.h>\n#include <stdlib.h>"
    built = library(folder / "made", Version.FMI3, f'{headers}\n{source}\n#include "echo3.c"')
    y = ['<Float64 name="y" valueReference="101" causality="output"/>']
    text = description3(y, ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>'])
    return pack(folder / "m.fmu", Version.FMI3, text, built)


def default_signals():
    """Signals as a person's shell leaves them to a command: one that starts tests in the background ignores some."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def started(folder, *arguments, prepare=default_signals, **how):
    return subprocess.Popen(
        [COMMAND, *map(str, arguments)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=prepare,  # noqa: PLW1509 - it only sets signals
        start_new_session=True,
        **how,
    )


def ended(process):
    """The exit code, and what was said on standard error."""
    _, err = process.communicate(timeout=600)
    return process.returncode, err


def wait_for(holds):
    while not holds():
        time.sleep(0.05)


def rows_of(folder):
    return len(pd.read_parquet(folder / "signals.parquet"))


def rows_so_far(folder):
    """The rows on disk of a run that goes on."""
    return sum(len(pd.read_parquet(path)) for path in (folder / "rows").glob("part-*.parquet"))


def test_python_files_in_the_working_folder_are_not_imported(tmp_path):
    model(tmp_path, "#define STATUS 0")
    for name in ("queue", "statistics", "fmpy", "fmus", "orchestrator", "numpy", "json", "casadi", "rerun", "loky"):
        (tmp_path / f"{name}.py").write_text("open('imported', 'a').write(__name__)")
    for name in ("fmus", "components", "pandas"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("open('imported', 'a').write(__name__)")
    swept = ("sweep", "static", "--blocks", "--stop-time", 0.3, "--vary", "plant.m=1500,1600", "--jobs", 2)
    for arguments in (("check", "m.fmu"), ("run", "m.fmu", "--stop-time", 1, "--step", 0.1), ("list",), swept):
        code, err = ended(started(tmp_path, *arguments))
        assert code == 0, err
    assert not (tmp_path / "imported").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("step", "found"),
    [
        ("*(volatile int *)8", "SIGSEGV"),
        ("(abort(), 0)", "SIGABRT"),
        ("(exit(0), 0)", "exit code 0|SIGSEGV|SIGABRT"),  # other threads may not stand the end of the library
        ("(_exit(7), 7)", "exit code 7"),
    ],
)
def test_a_process_that_an_fmu_ends_is_told_and_its_rows_are_kept(tmp_path, step, found):
    model(tmp_path, f"#define STATUS (usleep(100000), t > 2.95 ? {step} : 0)")
    arguments = ("run", "m.fmu", "--stop-time", 4, "--step", 0.1, "--in-process", "--out", "r")
    code, err = ended(started(tmp_path, *arguments))
    assert code == 1
    assert re.search(
        rf"macrostep: the run ended in a fault: the process that steps died \(({found}); the last call", err
    ), err
    assert "of an FMU in this process was `fmi3DoStep`)" in " ".join(err.split())
    told = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert told["status"] == "fault"
    assert re.search(found, told["fault"]["reason"])
    assert 10 <= rows_of(tmp_path / "r") == told["experiment"]["ticks"] <= 31


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_that_ask_for_an_end_act_as_ctrl_c(tmp_path, number):
    model(tmp_path, "#define STATUS (usleep(1000), 0)")
    process = started(tmp_path, "run", "m.fmu", "--stop-time", "1e5", "--step", "0.1", "--out", "r")
    wait_for((tmp_path / "r" / "recording.rrd").exists)
    time.sleep(1.0)
    process.send_signal(number)
    code, err = ended(process)
    assert code == 130
    told = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert told["status"] == "interrupted"
    assert f"macrostep: interrupted after {told['experiment']['ticks']} ticks" in err
    assert rows_of(tmp_path / "r") == told["experiment"]["ticks"] > 0


@pytest.mark.slow
def test_a_hang_of_an_fmu_in_the_process_ends_at_ctrl_c(tmp_path):
    model(tmp_path, "#define STATUS (t > 0.25 ? ({ for (;;) sleep(1); 0; }) : 0)")
    arguments = ("run", "m.fmu", "--stop-time", 1, "--step", 0.1, "--in-process", "--out", "r")
    process = started(tmp_path, *arguments)
    wait_for(lambda: rows_so_far(tmp_path / "r") == 4)  # which is where it hangs
    os.killpg(process.pid, signal.SIGINT)
    code, err = ended(process)
    assert code == 130
    assert "macrostep: interrupted; the process that steps did not stop within 10 s and was ended" in err
    assert json.loads((tmp_path / "r" / "summary.json").read_text())["status"] == "interrupted"
    assert rows_of(tmp_path / "r") == 4


@pytest.mark.slow
def test_the_process_that_steps_ends_with_the_one_that_outlives_it(tmp_path):
    model(tmp_path, "#define STATUS (usleep(1000), 0)")
    process = started(tmp_path, "run", "m.fmu", "--stop-time", "1e5", "--step", "0.1", "--out", "r")
    wait_for((tmp_path / "r" / "recording.rrd").exists)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert children
    process.kill()
    process.communicate()
    wait_for(lambda: not any(is_running(child) for child in children))


def is_running(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.slow
def test_signals_that_are_ignored_stay_ignored(tmp_path):
    """As `nohup` and shells that start a command in the background have it."""

    def ignored():
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

    model(tmp_path, "#define STATUS (usleep(1000), 0)")
    arguments = ("run", "m.fmu", "--stop-time", "1e5", "--step", "0.1", "--out", "r")
    process = started(tmp_path, *arguments, prepare=ignored)
    wait_for((tmp_path / "r" / "recording.rrd").exists)
    os.killpg(process.pid, signal.SIGHUP)
    os.killpg(process.pid, signal.SIGINT)
    time.sleep(1.0)
    assert process.poll() is None
    process.terminate()
    assert ended(process)[0] == 130


def test_what_a_library_writes_to_the_link_is_no_fact():
    told = _Told()
    told.take(b'garbage\n[1]\n{"folder": 3, "code": "x", "unknown": 1}\n\xff\n')
    assert told == _Told()
    told.take(b'{"folder": "runs/a-1"}\n{"ending": true}\n')
    assert (told.folder, told.ending, told.code) == ("runs/a-1", True, None)
    told.take(b'{"code": 0}\n')
    assert told.code == 0
