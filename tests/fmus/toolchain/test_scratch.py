from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.scratch import SCRATCH, scratch_folder, scratch_root
from fmus.units.isolated_messages import UnitReply

WAITS = "from fmus.toolchain.scratch import *; f = scratch_folder('x'); print(f.name, flush=True); input()"
ENDS = "from fmus.toolchain.scratch import *; f = scratch_folder('x'); print(f.name, flush=True)"
FORKS = """
import os, sys
from fmus.units.isolated_messages import UnitReply
from fmus.toolchain.scratch import scratch_folder
folder = scratch_folder("x")
child = os.fork()
if not child:
    sys.exit()
os.waitpid(child, 0)
print(os.path.isdir(os.path.dirname(folder.name)))
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Where the processes of a test have their temporary folders."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.delenv(SCRATCH, raising=False)
    return tmp_path


def started(code):
    return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def said(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_what_a_killed_process_left_is_removed_by_the_next_and_what_a_living_one_has_is_kept(place):
    with started(WAITS) as killed, started(WAITS) as lives:
        left, used = (Path(process.stdout.readline().strip()) for process in (killed, lives))
        killed.send_signal(signal.SIGKILL)
        killed.wait()
        assert left.is_dir()
        said(ENDS)
        assert not left.parent.exists()
        assert used.is_dir()
        lives.communicate("\n")
    assert list(place.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="only POSIX has it")
def test_a_forked_process_leaves_the_folder_of_its_origin_alone(place):
    assert said(FORKS) == "True"
    assert list(place.iterdir()) == []


def test_other_folders_with_our_name_are_no_concern(place):
    for name in ("macrostep_mine", "macrostep", "other"):
        (place / name).mkdir()
    said(ENDS)
    assert {path.name for path in place.iterdir()} == {"macrostep_mine", "macrostep", "other"}


def test_a_child_has_its_folders_in_those_of_its_parent():
    child = ChildProcess("fmus.units.isolated_process", UnitReply)
    try:
        environment = Path(f"/proc/{child._process.pid}/environ").read_text("utf-8").split("\0")
        assert f"{SCRATCH}={scratch_root()}" in environment
    finally:
        child.kill()
        child.close()


def test_a_folder_goes_with_its_block():
    with scratch_folder("made") as folder:
        assert Path(folder).parent == scratch_root()
        assert Path(folder).name.startswith("made_")
    assert not Path(folder).exists()
