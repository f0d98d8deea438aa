"""The process that reads damaged files one after the other, until one ends it: `python -m tests.fuzz.worker`.

It prints a line of JSON for each: its number, and what became of it.
"""

from __future__ import annotations

import faulthandler
import importlib
import json
import os
import pickle
import resource
import shutil
import signal
import sys
import traceback
import warnings
from pathlib import Path
from random import Random
from typing import IO, Any, Final

from components.interfaces.problem import Problem, RequestError
from fmus.toolchain.asked_library import readers_kept
from tests.fuzz.kinds import Kind, write
from tests.fuzz.seeds import Files

CPU_LIMIT: Final = 10.0
"""[s] The processor time that may be spent on one input."""
WALL_LIMIT: Final = 90.0
"""[s] The time that one input may take at all, in which child processes are waited for."""
MEMORY: Final = 3 * 2**30
"""[byte] The address space that may be taken beyond what the process has when it starts."""
ROOT: Final = Path(__file__).resolve().parents[2]


def main() -> None:
    """Read the inputs of a range of numbers."""
    module, name, seed, start, stop, stride, place = sys.argv[1:]
    kind, folder = importlib.import_module(module).KINDS[name], Path(place)
    lines = os.fdopen(os.dup(1), "w")
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    sound = pickle.loads((folder / "sound").read_bytes())  # noqa: S301 - the parent wrote it
    warnings.simplefilter("ignore")
    write(sound[0], folder / "first")
    judged(kind, folder / "first")  # imports everything
    _limit_memory()
    faulthandler.enable()
    for limit in (signal.SIGPROF, signal.SIGALRM):
        faulthandler.register(limit, chain=True)  # says where the process is before it ends
    with readers_kept():
        _read_all(kind, int(seed), range(int(start), int(stop), int(stride)), folder, sound, lines)


def _read_all(kind: Kind, seed: int, numbers: range, folder: Path, sound: list[Files], lines: IO[str]) -> None:
    for number in numbers:
        made = folder / "made"
        shutil.rmtree(made, ignore_errors=True)
        made.mkdir()
        write(kind.damaged(generator(seed, kind.name, number), sound), made)
        signal.setitimer(signal.ITIMER_PROF, CPU_LIMIT)
        signal.setitimer(signal.ITIMER_REAL, WALL_LIMIT)
        verdict = judged(kind, made)
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
        lines.write(json.dumps({"number": number, **verdict}) + "\n")
        lines.flush()


def generator(seed: int, kind: str, number: int) -> Random:
    """What an input follows from."""
    return Random(f"{seed} {kind} {number}")  # noqa: S311 - it shall be repeatable


def _limit_memory() -> None:
    taken = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def judged(kind: Kind, folder: Path) -> dict[str, Any]:
    """What became of the files in a folder."""
    try:
        problems = kind.read(folder)
    except RequestError as error:
        problems = error.problems or ["none"]
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is no refusal in words
        return {"outcome": "unworded", "where": _last_frame(error), "what": _shortened(error)}
    for problem in problems or ():
        if isinstance(problem, Problem) and not (problem.where and problem.found and problem.valid):
            return {"outcome": "unworded", "where": "a refusal with empty parts", "what": str(problem)[:200]}
    return {"outcome": "refused" if problems else "accepted"}


def _last_frame(error: BaseException) -> str:
    """The last place in the project that an exception went through, and its type."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if Path(f.filename).is_relative_to(ROOT) and ".venv" not in f.filename]
    own = [f for f in own if "/tests/" not in f.filename] or own
    place = f"{Path(own[-1].filename).relative_to(ROOT)}:{own[-1].lineno} in {own[-1].name}" if own else "?"
    return f"{type(error).__name__} at {place}"


def _shortened(error: BaseException) -> str:
    try:
        return str(error)[:300]
    except Exception as other:  # noqa: BLE001
        return f"an error without a text ({type(other).__name__})"


if __name__ == "__main__":
    main()
