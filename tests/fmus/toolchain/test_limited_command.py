"""A command on foreign files takes no more time, memory and disk than it may, and leaves nothing behind."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from fmus.toolchain.limited_command import CommandLimits, run_limited

AMPLE = CommandLimits(time=60.0, memory=4 * 2**30, output=2**26)
PYTHON = [sys.executable, "-c"]


def test_a_command_ends_as_it_would_and_what_it_says_is_kept(tmp_path):
    said = "import sys, os; print(os.getcwd(), os.environ['X'], file=sys.stderr); sys.exit(3)"
    done = run_limited([*PYTHON, said], tmp_path, AMPLE, {"X": "y"})
    assert (done.code, done.said.strip()) == (3, f"{tmp_path} y")


def test_of_much_that_it_says_the_beginning_is_kept(tmp_path):
    done = run_limited([*PYTHON, "import sys; sys.stderr.write('x' * 1_000_000)"], tmp_path, AMPLE)
    assert (done.code, done.said) == (0, "x" * 2**16)


@pytest.mark.skipif(os.name != "posix", reason="process groups are of POSIX")
def test_what_takes_too_long_is_ended_with_all_that_it_started(tmp_path):
    forks = f"import subprocess, time; p = subprocess.Popen({[*PYTHON, 'import time; time.sleep(1000)']!r});"
    writes = f"open({str(tmp_path / 'child')!r}, 'w').write(str(p.pid)); time.sleep(1000)"
    done = run_limited([*PYTHON, forks + writes], tmp_path, CommandLimits(10.0, 4 * 2**30, 2**26))
    assert done.code is None
    child = int((tmp_path / "child").read_text())
    until = time.monotonic() + 60  # the grandchild is reaped by another process
    while time.monotonic() < until and is_running(child):
        time.sleep(0.02)
    assert not is_running(child)


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{pid}/stat")
    return not (status.exists() and ") Z " in status.read_text())  # nobody has asked for its end yet


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of memory is of Linux")
def test_memory_and_files_have_limits(tmp_path):
    small = CommandLimits(60.0, 2**29, 2**20)
    done = run_limited([*PYTHON, "bytearray(2**30)"], tmp_path, small)
    assert (done.code, "MemoryError" in done.said) == (1, True)
    written = "import signal; signal.signal(signal.SIGXFSZ, signal.SIG_DFL); open('big', 'wb').write(bytes(2**22))"
    assert run_limited([*PYTHON, written], tmp_path, small).code not in {0, None}
    assert (tmp_path / "big").stat().st_size <= 2**20


def test_its_temporary_files_go_with_it(tmp_path):
    kept = tmp_path / "place"
    run_limited([*PYTHON, f"import os; open({str(kept)!r}, 'w').write(os.environ['TMPDIR'])"], tmp_path, AMPLE)
    assert not Path(kept.read_text()).exists()
