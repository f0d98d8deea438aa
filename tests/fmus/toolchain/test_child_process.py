"""A child process answers, is silent, dies or lives on; this process learns which, and nothing stays behind."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest

from fmus.toolchain import child_process
from fmus.toolchain.child_process import ChildDiedError, ChildProcess, ChildSilentError, Death

ANSWER = tuple[str, Any, bytes]
SOURCE = """
import os, sys, time
from fmus.toolchain.child_process import ParentProcess

parent = ParentProcess()
print("nobody takes this for an answer", flush=True)
os.write(1, b"nor this")
while True:
    try:
        request = parent.request()
    except EOFError:
        break
    if isinstance(request, float):
        time.sleep(request)
    if isinstance(request, int):
        os._exit(request)
    if request == "crash":
        os.abort()
    if request == "half":
        os.write(parent._answers.fileno(), parent._seal.sealed(b"a long answer")[:-5])
        os._exit(3)
    if request == "leave":
        parent._answers.close()
        time.sleep(100000)
    parent.answer(["answer to", request, os.read(0, 10)])
"""


@pytest.fixture
def child(tmp_path):
    (tmp_path / "answering_child.py").write_text(SOURCE)
    with (tmp_path / "errors").open("wb") as errors:
        process = ChildProcess("answering_child", ANSWER, {"PYTHONPATH": str(tmp_path)}, errors)
        yield process
        process.kill()
        process.close()


def open_files():
    return {p.name for p in Path("/proc/self/fd").iterdir()}


def test_requests_are_answered_in_order_whatever_the_child_prints_or_reads(child, tmp_path):
    for request in ("one", ["two", None], "x" * 1_000_000):
        assert child.ask(request, 60.0) == ("answer to", request, b"")
    assert child.ask("without a deadline") == ("answer to", "without a deadline", b"")
    child.requests.close()  # nobody asks any more
    assert child.death(60.0) == Death(0)
    assert (tmp_path / "errors").read_text() == "nobody takes this for an answer\nnor this"


def test_a_child_that_is_silent_is_ended(child):
    child.ask("ready", 60.0)
    with pytest.raises(ChildSilentError, match=r"did not answer within 0\.2 s") as error:
        child.ask(1e5, 0.2)
    assert error.value.within == 0.2
    death = child.death()
    assert death is not None
    assert death.signal is signal.SIGKILL
    assert not child.is_alive


@pytest.mark.parametrize(
    ("message", "death"), [(7, Death(7)), (0, Death(0)), ("crash", Death(-signal.SIGABRT)), ("half", Death(3))]
)
def test_how_a_child_died_is_data(child, message, death):
    with pytest.raises(ChildDiedError) as error:
        child.ask(message, 60.0)
    assert error.value.death == death
    assert death.signal == (signal.SIGABRT if message == "crash" else None)
    with pytest.raises(ChildDiedError):
        child.ask("anybody there?", 60.0)


def test_a_child_that_only_closes_its_streams_is_no_dead_one(child, monkeypatch):
    monkeypatch.setattr(child_process, "_DIES_WITHIN", 0.1)
    with pytest.raises(ChildDiedError) as error:
        child.ask("leave", 60.0)
    assert error.value.death is None
    assert child.is_alive


def test_a_module_that_cannot_be_run_is_a_death():
    process = ChildProcess("no_such_module_anywhere", str)
    with pytest.raises(ChildDiedError) as error:
        process.ask("anybody there?", 60.0)
    assert error.value.death == Death(1)
    process.close()


def test_nothing_stays_behind(tmp_path):
    before = open_files()
    (tmp_path / "answering_child.py").write_text(SOURCE)
    with Path(tmp_path, "errors").open("w+b") as errors:
        process = ChildProcess("answering_child", ANSWER, {"PYTHONPATH": str(tmp_path)}, errors)
        process.ask("one", 60.0)
        assert os.getsid(process._process.pid) != os.getsid(0), "Ctrl-C is for this process only"
        process.kill()
        process.close()
        process.close()
        errors.seek(0)
        assert errors.read() == b"nobody takes this for an answer\nnor this"
    assert open_files() <= before
