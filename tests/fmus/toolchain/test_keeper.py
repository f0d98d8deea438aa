"""Nothing that a child has started stays behind, and it ends as `child_death.py` says, whatever ends whom."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fmus.toolchain.child_death import ChildDiedError, Death, death_in_words
from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.limits import LARGEST_OUTPUT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux gives orphans to another process")

CHILD = """
import os, signal, sys, time
from fmus.toolchain.child_process import ParentProcess

parent = ParentProcess()

def orphan():
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            time.sleep(1000)
        os._exit(0)

parent.answer(os.getppid())
while True:
    request = parent.request()
    if request == "orphans":
        for _ in range(20):
            orphan()
    if request == "killed":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(1000)
    if request == "stopped":
        os.kill(os.getppid(), signal.SIGSTOP)
    if request == "group":
        os.kill(0, signal.SIGTERM)
        time.sleep(1000)
    if request == "prints":
        sys.stderr.write("\\x1b[2Jcaf\\u00e9\\n")
        sys.stderr.flush()
        for _ in range(100):
            os.write(1, b"x" * 1000)
    if isinstance(request, int):
        os._exit(request)
    parent.answer(os.getpid())
"""


@pytest.fixture
def child(tmp_path, monkeypatch):
    (tmp_path / "child_with_orphans.py").write_text(CHILD)
    monkeypatch.setenv("THEIRS", str(tmp_path))  # what it has started is told by this
    with (tmp_path / "errors").open("wb") as errors:
        process = ChildProcess("child_with_orphans", int, {"PYTHONPATH": str(tmp_path)}, errors)
        process.answer(60.0)
        yield process
        process.kill()
        process.close()


def theirs(place):
    """The processes that have a variable in their environment, but this one."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            environment = (process / "environ").read_bytes()
        except OSError:
            continue
        if f"THEIRS={place}\0".encode() in environment and int(process.name) != os.getpid():
            found.append(process.name)
    return found


def become(number, place):
    """Wait until there are so many processes, or more; for none, until there are none."""
    for _ in range(400):
        if len(theirs(place)) >= number > 0 or (number == 0 and not theirs(place)):
            return True
        time.sleep(0.05)
    return False


def nothing_left(place):
    return become(0, place)


@pytest.mark.parametrize("end", [0, 3, "killed", "group", None], ids=str)
def test_what_a_child_has_started_ends_with_it(child, tmp_path, end):
    child.ask("orphans", 60.0)
    assert become(22, tmp_path)
    if end is None:
        child.kill()
    else:
        with pytest.raises(ChildDiedError) as error:
            child.ask(end, 60.0)
        words = {"killed": "SIGKILL", "group": "SIGTERM"}
        assert death_in_words(error.value.death) == words.get(end, f"exit code {end}")
    child.kill()
    child.close()
    assert nothing_left(tmp_path)


def test_a_keeper_that_was_stopped_is_ended_too(child, tmp_path):
    child.ask("orphans", 60.0)
    child.ask("stopped", 60.0)
    child.kill()
    assert child.death() == Death(-signal.SIGKILL)
    assert nothing_left(tmp_path)


def test_what_a_child_prints_is_plain_and_bounded(child, tmp_path):
    child.ask("prints", 60.0)
    child.kill()
    text = (tmp_path / "errors").read_text("utf-8")
    assert text.startswith("\\x1b[2Jcafé\nxxx")
    assert text.endswith("x\n(the rest of what it prints is left out)\n")
    assert len(text) < LARGEST_OUTPUT + 100


PARENT = """
import sys, time
from fmus.toolchain.child_process import ChildProcess
child = ChildProcess("child_with_orphans", int)
child.answer(60.0)
child.ask("orphans", 60.0)
print("ready", flush=True)
time.sleep(1000)
"""


def test_children_and_what_they_have_started_end_with_a_parent_that_is_killed(tmp_path):
    (tmp_path / "child_with_orphans.py").write_text(CHILD)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "THEIRS": str(tmp_path)}
    call = [sys.executable, "-c", PARENT]
    with subprocess.Popen(call, env=environment, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout.readline() == "ready\n"
        enough = become(23, tmp_path)
        parent.kill()
    assert enough
    assert nothing_left(tmp_path)
