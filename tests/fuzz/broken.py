"""A kind whose reader is not in order, to see that the harness notices."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from components.interfaces.problem import refuse
from tests.fuzz.kinds import Kind


def _read(folder: Path) -> None:
    word = (folder / "a.txt").read_text("ascii")
    if word.startswith("refused"):
        raise refuse("a.txt", "a wrong word", "another")
    if word.startswith("fails"):
        raise KeyError(word)
    if word.startswith("dies"):
        os.kill(os.getpid(), signal.SIGSEGV)
    if word.startswith("hangs"):
        signal.setitimer(signal.ITIMER_PROF, 0.1)  # instead of the whole time
        while True:
            pass


WORDS = ("fine", "refused", "fails", "fails for longer", "dies", "hangs")
KINDS = {
    "broken": Kind(
        "broken",
        lambda: [{"a.txt": b"fine"}],
        (("a.txt", lambda _, random, __: random.choice(WORDS).encode()),),
        _read,
    )
}
