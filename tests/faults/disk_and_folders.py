"""Full disks, and folders that are moved, removed, shared or not what they seem: words, and every row that fits."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pandas as pd

from tests.faults.commands import LASTS, Started, is_whole
from tests.faults.scoring import fault
from tests.faults.security import simple

GROUP = "disk and folders"
TICKS = 114
"""Those of the scenario `static`."""


@contextmanager
def small_disk(folder, kilobytes):
    """A disk of its own with so much room; None where this process may not mount one."""
    disk = folder / "disk"
    disk.mkdir()
    mount = [shutil.which("mount") or "mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(disk)]
    if os.name != "posix" or subprocess.run(mount, capture_output=True, check=False).returncode:
        print("not done: this process may not mount a disk")  # noqa: T201 - it is a command
        yield None
        return
    try:
        yield disk
    finally:
        subprocess.run([shutil.which("umount") or "umount", "-l", str(disk)], check=True)


def rows_in(folder):
    """The rows that are on disk, from the first tick on without a gap; no other file with a final name is partial."""
    whole = folder / "signals.parquet"
    if not whole.exists() and not list((folder / "rows").glob("part-*")):
        return pd.DataFrame({"time": []})  # not even the first of them has room
    rows = pd.read_parquet(whole if whole.exists() else folder / "rows")
    assert np.rint(rows["time"] / 0.1).tolist() == list(range(len(rows)))
    for picture in (folder / "figures").glob("[!.]*"):
        assert picture.stat().st_size > 0
    return rows


def typed(folder, *arguments, **how):
    return Started(folder, *arguments, **how).end()


def full(least, most):
    def check(folder, random):
        room = random.randint(least, most)
        with small_disk(folder, room) as disk:
            if disk is None:
                return
            code, said = typed(folder, "run", "static", "--blocks", "--out", disk / "r")
            if code == 2:
                assert "No space left on device" in said
                assert not (disk / "r").exists()
                return
            told = json.loads((disk / "r" / "summary.json").read_text("utf-8"))
            rows = rows_in(disk / "r")
            if code == 0:
                assert len(rows) == told["experiment"]["ticks"] == TICKS, said
                assert (disk / "r" / "recording.rrd").exists() or "recording.rrd is left out" in said, said
            else:
                assert (code, told["status"]) == (1, "fault"), (room, code, said)
                assert "No space left on device" in said, said

    return check


for least, most, short in ((40, 250, False), (250, 700, True), (700, 1250, False), (1250, 2200, False)):
    fault(GROUP, f"a disk with {least} to {most} kB", short=short)(full(least, most))


@fault(GROUP, "a disk that becomes full during the run", short=False)
def becomes_full(folder, random):
    with small_disk(folder, 6000) as disk:
        if disk is None:
            return
        run = Started(folder, *LASTS, "--realtime", 0.5, "--out", disk / "r")
        run.wait_for("disk/r/rows/part-000001.parquet")
        while run.process.poll() is None and not len(rows_in(disk / "r")):
            time.sleep(0.05)
        time.sleep(2 * random.random())
        fill(disk)
        code, said = run.end()
        assert code == 1, said
        assert "No space left on device" in said
        rows = rows_in(disk / "r")
        assert 1 <= len(rows) < TICKS, (len(rows), said)


@fault(GROUP, "a disk that is full for some seconds", short=False)
def full_for_a_time(folder, random):
    with small_disk(folder, 20_000) as disk:
        if disk is None:
            return
        run = Started(folder, *LASTS, "--realtime", 1, "--out", disk / "r")
        run.wait_for("disk/r/rows/part-000001.parquet")
        time.sleep(random.random())
        fill(disk)
        time.sleep(2)
        (disk / "full").unlink()
        code, said = run.end()
        assert code == 0, said
        is_whole(disk / "r", "finished")


def fill(disk):
    with (disk / "full").open("wb", buffering=0) as file:
        try:
            while True:
                file.write(bytes(4096))
        except OSError:
            return


@fault(GROUP, "files may not be larger than 200 kB", short=False)
def limited(folder, _):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    code, said = typed(folder, "run", "static", "--blocks", "--out", "r", preexec_fn=limit)
    if code == 0:
        assert "recording.rrd is left out" in said, said
    assert len(rows_in(folder / "r")) == TICKS


def during(folder, random, act):
    """Do something to the folder of a run that steps; give the exit code and what it says."""
    for pace in (3, 0.5, 0.1):  # on a loaded machine a run may be over before anything is done to it
        run = Started(folder, *LASTS, "--realtime", pace, "--out", "r")
        run.wait_for("r/rows/part-000001.parquet")
        time.sleep(2 * random.random())
        with run.stopped():
            if steps := (folder / "r" / "rows").is_dir():
                act()
        ended = run.end()
        if steps:
            return ended
    raise AssertionError("every run was over too soon")


@fault(GROUP, "the folder is removed during the run")
def removed(folder, random):
    code, said = during(folder, random, lambda: shutil.rmtree(folder / "r", ignore_errors=True))
    there = next(folder.glob("r-rescued-*"))
    assert f"r was removed during the run: what could be saved of it is in {there}" in said, said
    assert code == 0, said
    assert len(rows_in(there)) == TICKS
    is_whole(there, "finished")
    assert (there / "recording.rrd").stat().st_size


@fault(GROUP, "the folder is renamed during the run", short=False)
def renamed(folder, random):
    code, said = during(folder, random, lambda: (folder / "r").rename(folder / "other"))
    assert code == 0, said
    assert f"r was moved during the run: it is {folder / 'other'} now" in said
    is_whole(folder / "other", "finished")
    assert sorted(p.name for p in folder.iterdir()) == ["other"]


@fault(GROUP, "another folder takes the place of that of the run", short=False)
def replaced(folder, random):
    def act():
        (folder / "r").rename(folder / "other")
        (folder / "r").mkdir()
        (folder / "r" / "notes.txt").write_text("mine")

    code, said = during(folder, random, act)
    assert code == 0, said
    is_whole(folder / "other", "finished")
    assert [p.name for p in (folder / "r").iterdir()] == ["notes.txt"]


@fault(GROUP, "files of the run are removed during the run", short=False)
def files_removed(folder, random):
    def act():
        for name in ("system.ssp", "manifest.json", ".draft.json", "rows/part-000001.parquet", "rows/_common_metadata"):
            (folder / "r" / name).unlink()

    code, said = during(folder, random, act)
    assert code == 0, said
    assert "system.ssp was removed during the run, and has been written again" in said
    is_whole(folder / "r", "finished")


@fault(GROUP, "two runs want one folder", short=False)
def two(folder, _):
    run = Started(folder, "run", "static", "--blocks", "--realtime", 0.01, "--out", "r")
    run.wait_for("r/rows/part-000001.parquet")
    code, said = typed(folder, "run", "static", "--blocks", "--out", "r")
    assert code == 2, said
    assert "r: found a folder that process " in said
    assert " is writing to; valid: " in said
    run.process.send_signal(signal.SIGINT)
    assert run.end()[0] == 130
    is_whole(folder / "r", "interrupted")


@fault(GROUP, "two runs want one folder at the same moment", short=False)
def two_at_once(folder, _):
    runs = [Started(folder, "run", "static", "--blocks", "--out", "r") for _ in range(2)]
    ended = [run.end() for run in runs]
    # one after the other is as good: the second replaces the first then
    assert sorted(code for code, _ in ended) in ([0, 2], [0, 0]), ended
    is_whole(folder / "r", "finished")


@fault(GROUP, "eight runs want the next folder", short=False)
def eight(folder, _):
    runs = [Started(folder, "run", "idle", "--blocks") for _ in range(8)]
    assert [run.end()[0] for run in runs] == [0] * 8
    assert sorted(p.name for p in (folder / "runs").iterdir()) == [f"idle-{i}" for i in range(1, 9)]
    for made in (folder / "runs").iterdir():
        is_whole(made, "finished")


THREADS = """
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.loading import load
from orchestrator.execution import Execution, execute
from orchestrator.scenario.options import Options

made = load("static", Options(mode="blocks"))
def one(_):
    try:
        return str(execute(made, Path("r"), SILENT, Execution(realtime=4.0, figures=False)).folder)
    except RequestError as error:
        return str(error)
with ThreadPoolExecutor(3) as pool:
    print(*sorted(pool.map(one, range(3))), sep="\\n")
"""


@fault(GROUP, "threads of one process want one folder", short=False)
def threads(folder, _):
    done = subprocess.run(
        [sys.executable, "-c", THREADS], cwd=folder, capture_output=True, text=True, check=True, timeout=300
    )
    lines = done.stdout.splitlines()
    assert lines[0] == "r", done
    assert all("found a folder that this process" in line for line in lines[1:]), done
    is_whole(folder / "r", "finished")


def leaving(*options, short):
    @fault(GROUP, f"an FMU changes the working folder {' '.join(options) or 'of its own process'}", short=short)
    def check(folder, _):
        elsewhere = folder / "elsewhere"
        elsewhere.mkdir()
        simple(
            folder,
            source=f"""
#include <unistd.h>
__attribute__((constructor)) static void leave(void) {{ if (chdir("{elsewhere}")) _exit(1); }}
#include "echo3.c"
""",
        )
        code, said = typed(folder, "run", "m.fmu", *options, "--stop-time", 1, "--step", 0.1, "--out", "r")
        assert code == 0, said
        is_whole(folder / "r", "finished")
        assert (folder / "r" / "recording.rrd").exists()
        assert list(elsewhere.iterdir()) == []


leaving("--in-process", short=True)
leaving(short=False)


@fault(GROUP, "a link stands where the run writes", short=False)
def link(folder, random):
    assert typed(folder, "run", "idle", "--blocks", "--out", "r")[0] == 0
    mine = folder / "mine"
    mine.write_text("mine")
    name = random.choice(["recording.rrd", "signals.parquet", "summary.json", "system.ssp"])
    (folder / "r" / name).unlink()
    (folder / "r" / name).symlink_to(mine)
    code, said = typed(folder, "run", "idle", "--blocks", "--out", "r")
    assert (code, mine.read_text()) == (2, "mine"), said
    assert f"r/{name}: found a link" in said


@fault(GROUP, "a person's files stand beside those of a former run", short=False)
def beside(folder, _):
    assert typed(folder, "run", "idle", "--blocks", "--out", "r")[0] == 0
    for name in ("notes.txt", "figures/mine.png", ".git"):
        (folder / "r" / name).write_text("mine")
    code, said = typed(folder, "run", "idle", "--blocks", "--out", "r")
    assert code == 0, said
    assert "note: r: what else was in this folder stays: .git, figures, notes.txt" in said
    assert [(folder / "r" / n).read_text() for n in ("notes.txt", "figures/mine.png", ".git")] == ["mine"] * 3
    is_whole(folder / "r", "finished")
