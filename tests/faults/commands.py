"""The command in processes of its own, as a person starts it, and what has to hold of it whatever is done to it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq

COMMAND = str(Path(sys.executable).with_name("macrostep"))
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
LASTS = ("run", "static", "--blocks", "--realtime", "3")
"""A run of four seconds."""


class Started:
    """A command that runs in a folder, in a session of its own.

    Args:
        folder: Its working folder.
        arguments: What stands after `macrostep`.
        how: More arguments of `subprocess.Popen`.
    """

    def __init__(self, folder, *arguments, **how):
        self.folder = folder

        def default_signals():  # whoever starts the faults in the background ignores some
            for number in SIGNALS:
                signal.signal(number, signal.SIG_DFL)

        self.process = subprocess.Popen(
            [COMMAND, *map(str, arguments)],
            **{
                "cwd": folder,
                "stdout": subprocess.PIPE,
                "stderr": subprocess.PIPE,
                "text": True,
                "preexec_fn": default_signals,
                "start_new_session": True,
                **how,
            },
        )

    def wait_for(self, name):
        """Wait until there is a file, or the command has ended."""
        while self.process.poll() is None and not (self.folder / name).exists():
            time.sleep(0.01)

    def wait_for_rows(self, name):
        """Wait until a run has rows on disk, or has ended."""
        parts = self.folder / name / "rows"
        while self.process.poll() is None and not any(pq.read_metadata(p).num_rows for p in parts.glob("part-*")):
            time.sleep(0.01)

    @contextmanager
    def stopped(self):
        """Stop the command and what it has started, as long as a block lasts."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGSTOP)
        try:
            yield
        finally:
            with suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGCONT)

    def end(self, within=300):
        """Wait for the end; give the exit code and what stands on stderr, which is never a traceback."""
        try:
            _, said = self.process.communicate(timeout=within)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.communicate()
            raise AssertionError("it hangs") from None
        assert "Traceback" not in (said or ""), said
        assert not running(self.process.pid), "processes are left"
        return self.process.returncode, said or ""


def running(session):
    """The processes of a session that have not ended, some time after its leader has."""
    for _ in range(100):
        found = [p.name for p in Path("/proc").glob("[0-9]*") if _session(p) == session]
        if not found:
            return []
        time.sleep(0.1)
    return found


def _session(process):
    try:
        state, _, _, session = (process / "stat").read_text("utf-8").rpartition(")")[2].split()[:4]
    except OSError:
        return None
    return None if state == "Z" else int(session)


def is_whole(folder, status):
    """Check a run folder that the command has completed."""
    told = json.loads((folder / "summary.json").read_text("utf-8"))
    assert told["status"] == status, told
    rows = pd.read_parquet(folder / "signals.parquet")
    assert len(rows) == told["experiment"]["ticks"], (len(rows), told["experiment"])
    assert list(rows["time"]) == sorted(rows["time"])
    return told
