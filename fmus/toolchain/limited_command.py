"""A command on files of other makers, in a process group of its own, with limits of time, memory and output."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Final

from fmus.toolchain.scratch import scratch_folder

_KEPT: Final = 2**16
"""[byte] What is kept of what a command says."""
_LIMITS: Final = 'ulimit -c 0; ulimit -v {memory} 2>/dev/null; ulimit -f {output} 2>/dev/null; exec "$@"'
"""What the shell sets before it becomes the command; macOS has no limit of memory."""
_BLOCK: Final = 512
"""[byte] The unit of the limit of output."""


@dataclass(frozen=True)
class CommandLimits:
    """What a command may take.

    Attributes:
        time: [s] From its start to its end.
        memory: [byte] Of each of its processes.
        output: [byte] Of each file that it writes.
    """

    time: float
    memory: int
    output: int


@dataclass(frozen=True)
class EndedCommand:
    """How a command ended."""

    code: int | None
    """Its exit code, or the negative number of a signal; None for one that took too long, and was ended."""
    said: str
    """The beginning of what it wrote on standard error."""


def run_limited(
    command: Sequence[str], folder: Path, limits: CommandLimits, environment: Mapping[str, str] | None = None
) -> EndedCommand:
    """Run a command to its end, or end it and all that it has started when its time is over.

    Its temporary files go with it.

    Args:
        command: The program and its arguments.
        folder: Its working folder.
        limits: What it may take.
        environment: Variables that differ from those of this process.
    """
    with scratch_folder("command") as temporary:
        own = {**os.environ, **(environment or {}), "TMPDIR": temporary}
        place = Path(temporary) / "said"
        with place.open("wb") as errors:
            process = _started(command, folder, limits, own, errors)
            try:
                code = _end(process, limits.time)
            finally:
                _end_group(process)
        with place.open("rb") as errors:
            return EndedCommand(code, errors.read(_KEPT).decode("utf-8", "replace"))


def _started(
    command: Sequence[str], folder: Path, limits: CommandLimits, environment: Mapping[str, str], errors: IO[bytes]
) -> subprocess.Popen[bytes]:
    shell: list[str] = []
    if os.name == "posix":
        script = _LIMITS.format(memory=limits.memory // 1024, output=limits.output // _BLOCK)
        shell = ["/bin/sh", "-c", script, "sh"]
    return subprocess.Popen(  # noqa: S603 - the command is ours
        [*shell, *command],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=errors,
        env=dict(environment),
        start_new_session=True,  # Windows passes over it
    )


def _end(process: subprocess.Popen[bytes], within: float) -> int | None:
    try:
        return process.wait(within)
    except subprocess.TimeoutExpired:
        return None


def _end_group(process: subprocess.Popen[bytes]) -> None:
    """End a process and all that it has started."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):  # nothing is left of its group
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()
