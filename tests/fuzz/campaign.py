"""Damaged inputs of a kind, read in worker processes that are replaced when an input ends them."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from tests.fuzz.kinds import Kind, write
from tests.fuzz.seeds import Files
from tests.fuzz.worker import ROOT, generator

_AT_ONCE: Final = 3000
"""The inputs after which a worker is replaced: libraries keep memory."""
_FRAME: Final = re.compile(r'File "([^"]+)", line (\d+) in (\w+)')


@dataclass
class Found:
    """An input, or several at the same place, that was not refused in words."""

    what: str
    numbers: list[int] = field(default_factory=list[int])
    smallest: Path | None = None
    size: int = 0


@dataclass
class Tally:
    """What became of the inputs of a kind."""

    kind: str
    outcomes: Counter[str] = field(default_factory=Counter[str])
    found: dict[str, Found] = field(default_factory=dict[str, Found])
    """By the last place in the project, and the type of the exception."""

    @property
    def tried(self) -> int:
        """All inputs."""
        return sum(self.outcomes.values())

    @property
    def bad(self) -> int:
        """Those that were not refused in words."""
        return self.tried - self.outcomes["accepted"] - self.outcomes["refused"]


class Campaign:
    """Damaged inputs of one kind, which follow from a seed.

    Args:
        kind: The kind.
        seed: The seed.
        keep: Where inputs are kept that are not refused in words.
        module: The module that has the kind in its `KINDS`.
    """

    def __init__(self, kind: Kind, seed: int, keep: Path, module: str = "tests.fuzz.kinds") -> None:
        self._kind, self._seed, self._keep, self._module = kind, seed, keep, module
        self._sound: list[Files] = kind.seeds()
        self._lock = threading.Lock()
        self.tally = Tally(kind.name)

    def run(self, *, count: int, jobs: int, seconds: float | None = None) -> Tally:
        """Read the inputs.

        Args:
            count: How many.
            jobs: The processes at once.
            seconds: The time [s] after which no further ones are begun.
        """
        deadline = None if seconds is None else time.monotonic() + seconds
        jobs = min(jobs, count)
        threads = [threading.Thread(target=self._job, args=(j, count, jobs, deadline)) for j in range(jobs)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return self.tally

    def input(self, number: int) -> Files:
        """The files of an input."""
        return self._kind.damaged(generator(self._seed, self._kind.name, number), self._sound)

    def _job(self, number: int, count: int, stride: int, deadline: float | None) -> None:
        folder = Path(tempfile.mkdtemp(prefix="fuzz_"))
        (folder / "sound").write_bytes(pickle.dumps(self._sound))
        try:
            while number < count and (deadline is None or time.monotonic() < deadline):
                number = self._worker(folder, number, min(count, number + _AT_ONCE * stride), stride, deadline)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _worker(self, folder: Path, start: int, stop: int, stride: int, deadline: float | None) -> int:
        """Let a process read inputs; return the number of the next one."""
        temporary = folder / "tmp"
        shutil.rmtree(temporary, ignore_errors=True)
        temporary.mkdir()
        arguments = [self._module, self._kind.name, self._seed, start, stop, stride, folder]
        number = start
        with (
            (folder / "errors").open("w+b") as errors,
            subprocess.Popen(
                [sys.executable, "-m", "tests.fuzz.worker", *map(str, arguments)],
                cwd=ROOT,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=errors,
                env={**os.environ, "TMPDIR": str(temporary), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
                start_new_session=True,
            ) as process,
        ):
            for line in process.stdout or ():
                verdict = json.loads(line)
                self._count(verdict)
                number = verdict["number"] + stride
                if deadline is not None and time.monotonic() > deadline:
                    break
            else:
                os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # its number stays its own
                self._end_group(process.pid)
                if code := process.wait():
                    errors.seek(0)
                    self._count(_death(number, code, errors.read()[-20000:].decode("utf-8", "replace")))
                    number += stride
                return number
            self._end_group(process.pid)
        return number

    @staticmethod
    def _end_group(number: int) -> None:
        """End what a worker has started, and itself."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(number, signal.SIGKILL)

    def _count(self, verdict: dict[str, Any]) -> None:
        with self._lock:
            self.tally.outcomes[verdict["outcome"]] += 1
            if verdict["outcome"] in {"accepted", "refused"}:
                return
            found = self.tally.found.setdefault(verdict["where"], Found(verdict["what"]))
            found.numbers.append(verdict["number"])
            if len(found.numbers) > 50:
                return
            files = self.input(verdict["number"])
            if found.smallest is None or (size := sum(map(len, files.values()))) < found.size:
                size = sum(map(len, files.values()))
                place = self._keep / self._kind.name / re.sub(r"[^\w.]+", "_", verdict["where"])[:120]
                shutil.rmtree(place, ignore_errors=True)
                place.mkdir(parents=True)
                write(files, place)
                found.smallest, found.size, found.what = place, size, verdict["what"]


def _death(number: int, code: int, said: str) -> dict[str, Any]:
    """The verdict on an input that ended its process, or was ended because it took too long."""
    hung = code in {-signal.SIGPROF, -signal.SIGALRM}
    what = "a hang" if hung else signal.Signals(-code).name if code < 0 else f"exit code {code}"
    own = [
        f"{m[1].partition('/macrostep/')[2] or m[1]}:{m[2]} in {m[3]}"
        for m in _FRAME.finditer(said.rpartition("Current thread")[2])
    ]
    own = [frame for frame in own if frame.startswith(str(ROOT)) and ".venv" not in frame and "/tests/" not in frame]
    where = own[0].removeprefix(f"{ROOT}/") if own else "?"
    return {"number": number, "outcome": "hung" if hung else "died", "where": f"{what} at {where}", "what": said[-300:]}
