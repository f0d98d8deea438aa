"""What a library may change of its process is put back."""

from __future__ import annotations

import ctypes
import locale
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fmus.toolchain.process_state import ProcessState

UPWARD = 0x800  # FE_UPWARD on x86-64
C = ctypes.CDLL(None)


@pytest.fixture
def state(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    kept = ProcessState()
    yield kept
    kept.restore()
    kept.close()


def test_the_folder_the_permissions_and_the_locale_are_put_back(state, tmp_path):
    mask, words = os.umask(0o22), locale.setlocale(locale.LC_ALL)
    os.umask(mask)
    os.chdir("/")
    os.umask(0o777)
    locale.setlocale(locale.LC_ALL, "C")
    state.restore()
    assert Path.cwd() == tmp_path
    assert locale.setlocale(locale.LC_ALL) == words
    assert os.umask(mask) == mask


def test_a_folder_that_is_gone_is_no_fault(state, tmp_path):
    os.chdir("/")
    tmp_path.rmdir()
    state.restore()
    assert Path.cwd() == Path("/")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the C library of Linux")
def test_numbers_are_rounded_to_nearest_again(state):
    arithmetic = ctypes.CDLL("libm.so.6")
    nearest = arithmetic.fegetround()
    assert arithmetic.fesetround(UPWARD) == 0
    assert arithmetic.fegetround() == UPWARD
    state.restore_quickly()
    assert arithmetic.fegetround() == nearest


def test_ctrl_c_does_what_it_did(state):
    C.signal(int(signal.SIGINT), ctypes.c_void_p(1))  # ignored, without the knowledge of Python
    os.kill(os.getpid(), signal.SIGINT)
    state.restore_quickly()
    with pytest.raises(KeyboardInterrupt):
        _interrupted()


def _interrupted():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(30)


SOURCE = """
import os
from fmus.toolchain.process_state import ProcessState
state = ProcessState()
os.close(1)
os.close(2)
state.restore()
print("before", flush=True)
os.close(1)
assert os.open("theirs.txt", os.O_CREAT | os.O_WRONLY) == 1
state.restore()
print("after", flush=True)
state.close()
"""


def test_streams_are_open_again_and_are_the_same_files(tmp_path):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", SOURCE], check=True, cwd=tmp_path, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == ("before\nafter\n", "")
    assert (tmp_path / "theirs.txt").read_text() == ""
