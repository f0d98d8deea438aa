"""Signals at any time: what has been computed is kept, and nothing is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import time

from tests.faults.commands import LASTS, SIGNALS, Started, is_whole
from tests.faults.scoring import fault

GROUP = "signals"


def names(numbers):
    return [number.name for number in numbers]


def at_any_time(number, *, to_all):
    def check(folder, random):
        run = Started(folder, *LASTS, "--out", "r")
        run.wait_for_rows("r")
        time.sleep(3 * random.random())
        (os.killpg if to_all else os.kill)(run.process.pid, number)
        code, said = run.end()
        assert code == 130, (code, said)
        told = is_whole(folder / "r", "interrupted")
        assert f"interrupted after {told['experiment']['ticks']} ticks" in said
        assert (folder / "r" / "recording.rrd").stat().st_size > 0

    return check


for to_all, how in ((False, "to the command"), (True, "to all its processes")):
    for number in SIGNALS:
        fault(GROUP, f"{number.name} {how} at any tick", short=to_all and number is signal.SIGTERM)(
            at_any_time(number, to_all=to_all)
        )


def during_start(number):
    def check(folder, random):
        run = Started(folder, *LASTS, "--out", "r")
        time.sleep(1.2 * random.random())
        run.process.send_signal(number)
        code, said = run.end()
        assert code == 130, (code, said)
        if (folder / "r").exists():
            is_whole(folder / "r", "interrupted")

    return check


for number in SIGNALS:
    fault(GROUP, f"{number.name} during the start", short=False)(during_start(number))


@fault(GROUP, "SIGINT twice, the second while the folder is completed")
def twice(folder, random):
    run = Started(folder, *LASTS, "--out", "r")
    run.wait_for_rows("r")
    time.sleep(1)
    run.process.send_signal(signal.SIGINT)
    time.sleep(random.random())
    run.process.send_signal(signal.SIGINT)
    code, said = run.end()
    assert code == 130, (code, said)
    is_whole(folder / "r", "interrupted")
    assert (folder / "r" / "figures" / "trajectory.png").exists()


@fault(GROUP, "SIGSTOP and SIGCONT to all its processes", short=False)
def stopped(folder, random):
    run = Started(folder, "run", "static", "--blocks", "--realtime", "6", "--out", "r")
    run.wait_for_rows("r")
    time.sleep(random.random())
    os.killpg(run.process.pid, signal.SIGSTOP)
    time.sleep(2)
    os.killpg(run.process.pid, signal.SIGCONT)
    assert run.end()[0] == 0
    is_whole(folder / "r", "finished")


@fault(GROUP, "SIGKILL to the command, and the same folder again")
def killed(folder, random):
    run = Started(folder, *LASTS, "--out", "r")
    run.wait_for_rows("r")
    time.sleep(2 * random.random())
    run.process.kill()
    run.end()
    again = Started(folder, "run", "static", "--blocks", "--stop-time", 1, "--out", "r")
    code, said = again.end()
    assert code == 0, said
    is_whole(folder / "r", "finished")


@fault(GROUP, "ignored SIGINT and SIGHUP, as in the background under nohup", short=False)
def ignored(folder, _):
    def ignore():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    run = Started(folder, "run", "static", "--blocks", "--realtime", "6", "--out", "r", preexec_fn=ignore)
    run.wait_for_rows("r")
    os.killpg(run.process.pid, signal.SIGHUP)
    os.killpg(run.process.pid, signal.SIGINT)
    assert run.end()[0] == 0
    is_whole(folder / "r", "finished")


@fault(GROUP, "nobody reads what it prints", short=False)
def closed_pipe(folder, _):
    run = Started(folder, "run", "static", "--blocks", "--stop-time", 1, "--out", "r", stderr=subprocess.DEVNULL)
    run.process.stdout.close()
    run.process.wait(300)
    is_whole(folder / "r", "finished")


@fault(GROUP, "no standard streams at all")
def no_streams(folder, _):
    def close():
        for descriptor in (0, 1, 2):
            os.close(descriptor)

    none = {"stdout": None, "stderr": None, "preexec_fn": close}
    run = Started(folder, "run", "static", "--blocks", "--stop-time", 1, "--out", "r", **none)
    run.process.wait(300)
    is_whole(folder / "r", "finished")


@fault(GROUP, "SIGTERM while FMUs are built", short=False)
def while_building(folder, random):
    run = Started(folder, "build", "--out", "built")
    time.sleep(1.5 + random.random())
    run.process.send_signal(signal.SIGTERM)
    code, said = run.end()
    assert code in {0, 130}, (code, said)
    assert not list((folder / "built").rglob(".*")) if (folder / "built").exists() else True
