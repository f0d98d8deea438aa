"""The process that records is killed or stopped, and what it writes is removed: the run is whole, and it is told."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

from orchestrator.results.run_folder import find
from tests.faults.commands import LASTS, Started, _session, is_whole
from tests.faults.scoring import fault

GROUP = "recorder"


def recorders(session):
    """The processes of a session that record."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            command = (process / "cmdline").read_bytes()
        except OSError:
            continue
        if b"recording.worker" in command and _session(process) is not None and _parents(process, session):
            found.append(int(process.name))
    return sorted(found)


def _parents(process, ancestor):
    """Whether a process has an ancestor."""
    number = process.name
    while number not in {"0", "1", str(ancestor)}:
        try:
            number = Path(f"/proc/{number}/stat").read_text("utf-8").rpartition(")")[2].split()[1]
        except OSError:
            return False
    return number == str(ancestor)


def whole_with_recording(folder):
    is_whole(folder, "finished")
    assert find(folder).recording is not None
    assert not (folder / ".recording.rrd").exists()


def signalled(number, name, *, short):
    @fault(GROUP, name, short=short)
    def check(folder, random):
        run = Started(folder, *LASTS, "--out", "r")
        run.wait_for("r/recording.rrd")
        time.sleep(2.5 * random.random())
        for process in recorders(run.process.pid):
            os.kill(process, number)
        code, said = run.end()
        assert code == 0, said
        whole_with_recording(folder / "r")


signalled(signal.SIGKILL, "it is killed at any tick", short=True)
signalled(signal.SIGSEGV, "it crashes at any tick", short=False)
signalled(signal.SIGSTOP, "it is stopped at any tick", short=False)


@fault(GROUP, "it and every one that follows is killed", short=False)
def always_killed(folder, _):
    run = Started(folder, *LASTS, "--out", "r")
    run.wait_for("r/recording.rrd")
    over = threading.Event()

    def kill():
        while not over.wait(0.05):
            for process in recorders(run.process.pid):
                os.kill(process, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        code, said = run.end()
    finally:
        over.set()
        killer.join()
    assert code == 0, said
    is_whole(folder / "r", "finished")
    if "note: recording.rrd is left out: " in said:
        assert "macrostep show makes one from the rows" in said
        assert not list((folder / "r").glob("*recording.rrd"))
    else:  # one was quicker than the signals
        whole_with_recording(folder / "r")


def without(*names, short):
    @fault(GROUP, f"{' and '.join(names)} removed during the run", short=short)
    def check(folder, random):
        run = Started(folder, *LASTS, "--out", "r")
        run.wait_for("r/recording.rrd")
        time.sleep(1 + random.random())
        for name in names:
            (folder / "r" / name).unlink(missing_ok=True)
        code, said = run.end()
        assert code == 0, said
        whole_with_recording(folder / "r")


without("recording.rrd", short=False)
without(".recording.rrd", short=False)
without("recording.rrd", ".recording.rrd", short=False)
