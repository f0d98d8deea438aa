"""Runs of one FMU that does what it must not, by the facade or by the command, and what has to be true after them."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import pandas as pd

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator import Options, load
from orchestrator.execution import Execution, execute
from orchestrator.stepping.master import SimulationError

PATIENCE: Final = 1.0
"""[s] The time that an answer may take."""
LONGEST: Final = 200.0
"""[s] What a run may take in all: far from any patience, so that a busy machine is no fault and a hang is one."""
_END_WITHIN: Final = 20.0
"""[s] The time in which a process has to notice that the one that started it is gone: a busy machine is no fault."""
_MARK: Final = "MACROSTEP_FAULT"


class _Nothing(nullcontext):
    """Records nothing, in a file: these runs are many."""

    def begin(self, request, *_):
        Path(request.sink).touch()

    def wait_until_open(self):
        pass

    def end(self, *_):
        pass

    def wait(self):
        return ""


@dataclass(frozen=True)
class Ended:
    """How a run ended."""

    code: int
    said: str
    """All that was said: the error, or the notes."""
    rows: int
    """Rows in signals.parquet; -1 where there is no run folder."""


def run(fmu: Path, folder: Path, *, in_process: bool = False, **options) -> Ended:
    """Run an FMU by the facade, in a process of its own if nothing else is wanted."""
    began = time.monotonic()
    place: dict[str, object] = {"in_process": True} if in_process else {"isolate": (f"fmu:{PATIENCE}",)}
    with _marked() as mark:
        try:
            scenario = load(str(fmu), Options(step=0.1, stop_time=1.0, **place, **options))
            done = execute(scenario, folder / "out", SILENT, Execution(recorder=_Nothing(), figures=False))
        except RequestError as error:
            ended = Ended(2, str(error), -1)
        else:
            if done.ended is not None:
                assert isinstance(done.ended, SimulationError)
            said = "\n".join([*([str(done.ended)] if done.ended else []), *done.notes])
            ended = Ended(1 if done.ended else 0, said, _rows(folder / "out"))
        _check(ended, mark, began)
    return ended


def command(fmu: Path, folder: Path, *, place: Sequence[str] = ("--isolate", f"fmu:{PATIENCE}")) -> Ended:
    """Run an FMU by the command."""
    began = time.monotonic()
    call = [str(Path(sys.executable).with_name("macrostep")), "run", str(fmu), "--step", "0.1", "--stop-time", "1"]
    with _marked() as mark:
        done = subprocess.run(
            [*call, "--out", str(folder / "out"), *place],
            capture_output=True, text=True, errors="replace", timeout=LONGEST, check=False, cwd=folder,
        )  # fmt: skip
        said = done.stdout + done.stderr
        assert "Traceback" not in said, said[-2000:]
        ended = Ended(done.returncode, " ".join(said.split()), _rows(folder / "out"))
        assert "\x1b]" not in said, "an escape sequence reached the terminal"
        _check(ended, mark, began)
    return ended


def _rows(out: Path) -> int:
    if not out.is_dir():
        return -1
    assert json.loads((out / "summary.json").read_text("utf-8"))
    return len(pd.read_parquet(out / "signals.parquet"))


def _check(ended: Ended, mark: str, began: float) -> None:
    """What has to be true of every run."""
    took = time.monotonic() - began
    assert took < LONGEST, f"it took {took:.0f} s"
    assert len(ended.said) < 10_000, f"it said {len(ended.said)} characters"
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]", ended.said), f"control characters in {ended.said!r}"
    end = time.monotonic() + _END_WITHIN
    while (left := _marked_processes(mark)) and time.monotonic() < end:
        time.sleep(0.05)
    assert not left, f"{len(left)} processes are left"


class _marked:  # noqa: N801 - a context
    """Marks the processes that are started in a `with` statement, and ends those that are left."""

    def __enter__(self) -> str:
        self._mark = os.urandom(8).hex()
        os.environ[_MARK] = self._mark
        return self._mark

    def __exit__(self, *_) -> None:
        del os.environ[_MARK]
        for process in _marked_processes(self._mark):
            with suppress(OSError):
                os.kill(process, 9)


def _marked_processes(mark: str) -> list[int]:
    """The processes that have the mark in their environment, but this one."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            environment = (process / "environ").read_bytes().split(b"\0")
            if f"{_MARK}={mark}".encode() in environment and int(process.name) != os.getpid():
                found.append(int(process.name))
    return found
