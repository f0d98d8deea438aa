"""The process that outlives a run: it passes signals on, and tells and finishes what the process that steps cannot.

An FMU that runs in the process that steps can end it by a crash or by `exit`, and can hang so that no signal gets
through. The command is therefore two processes: this one imports nothing and loads nothing, waits, and completes the
run folder where the other one did not.
"""

from __future__ import annotations

import json
import mmap
import os
import select
import shlex
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Final

from components.interfaces.interruption import ENDING_SIGNALS, interruptible
from fmus.toolchain.last_call import LONGEST_NAME, last_call, note_calls

_STOPS_WITHIN: Final = 10.0
"""[s] The time that the process has to stop stepping, or to complete its folder, after a signal."""
_LOOKS_EVERY: Final = 0.2
"""[s] The time between two looks whether the process is alive."""
_OUTLIVED: Final = "run"
"""The subcommand that may load foreign libraries into its own process."""


class Lifeline:
    """What the process that steps tells the one that outlives it; nothing where there is none."""

    def __init__(self, descriptor: int | None = None) -> None:
        self._descriptor = descriptor

    def began(self, folder: Path) -> None:
        """Tell the run folder, as soon as it is there."""
        self._tell({"folder": str(folder)})

    def ends(self) -> None:
        """Tell that the last step is done, and that the folder is being completed."""
        self._tell({"ending": True})

    def concluded(self, code: int) -> None:
        """Tell the exit code; after it nothing can be lost any more."""
        self._tell({"code": code})

    def _tell(self, facts: Mapping[str, object]) -> None:
        if self._descriptor is not None:
            with suppress(OSError):  # a library has closed it
                os.write(self._descriptor, json.dumps(facts).encode() + b"\n")


@dataclass
class _Told:
    """What the process that steps has told."""

    folder: str = ""
    ending: bool = False
    code: int | None = None

    def take(self, lines: bytes) -> None:
        """Take what was read; what a library has written there is no fact."""
        for line in lines.splitlines():
            with suppress(ValueError):
                match json.loads(line):
                    case {"folder": str(folder)}:
                        self.folder = folder
                    case {"ending": True}:
                        self.ending = True
                    case {"code": int(code)}:
                        self.code = code
                    case _:
                        pass


def main() -> None:
    """Run the command; where it may load foreign libraries, in a process that this one outlives."""
    _import_nothing_from_here()
    if not hasattr(os, "fork") or sys.argv[1:2] != [_OUTLIVED] or "--help" in sys.argv:
        _command(Lifeline())
        return
    reading, writing = os.pipe()
    called = memoryview(mmap.mmap(-1, LONGEST_NAME))  # both processes have it
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDING_SIGNALS)  # they wait until both processes are ready for them
    try:
        process = os.fork()
    except OSError:  # no process can be started, and the command will say so where it needs one
        _command(Lifeline())
        return
    if process:
        os.close(writing)
        supervisor = _Supervisor(process, reading, called)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING_SIGNALS)
        sys.exit(supervisor.wait())
    os.close(reading)
    from fmus.toolchain.child_process import end_when_closed, moved  # noqa: PLC0415 - not in the other process

    descriptor = moved(writing)  # where no library takes it for its own
    os.close(writing)
    end_when_closed(descriptor)
    note_calls(called)
    _command(Lifeline(descriptor))


def _import_nothing_from_here() -> None:
    """Keep Python files in the working folder from being imported, by this process and by all that it starts."""
    sys.path[:] = [path for path in sys.path if Path(path).is_absolute()]
    os.environ["PYTHONSAFEPATH"] = "1"


def _command(lifeline: Lifeline) -> None:
    code = 1
    try:
        with interruptible():
            if hasattr(signal, "pthread_sigmask"):
                signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING_SIGNALS)
            from orchestrator.command import main as command  # noqa: PLC0415 - not in the process that outlives it

            command.main(lifeline)
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except KeyboardInterrupt:
        code = _interrupted()
    finally:
        lifeline.concluded(code)
    sys.exit(code)


def _interrupted() -> int:
    """Say that nothing was done, and return the exit code."""
    from orchestrator.command.console import INTERRUPTED, err  # noqa: PLC0415 - a command starts faster without it

    err.print("macrostep: interrupted", style="red")
    return INTERRUPTED


class _Supervisor:
    """Waits for the process that steps, passes signals on, and concludes for it where it cannot."""

    def __init__(self, process: int, reading: int, called: memoryview) -> None:
        self._process, self._reading, self._called = process, reading, called
        self._told = _Told()
        self._deadline = float("inf")
        self._interrupted = self._killed = False
        for number in ENDING_SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:  # as a shell or `nohup` has it
                signal.signal(number, self._pass_on)

    def _pass_on(self, number: int, _: FrameType | None) -> None:
        """Pass a signal on; one from the terminal has reached the other process too, which takes both for one."""
        self._interrupted = True
        self._deadline = time.monotonic() + _STOPS_WITHIN
        with suppress(ProcessLookupError):
            os.kill(self._process, number)

    def wait(self) -> int:
        """Wait for the end of the process; return the exit code of the command."""
        status = None
        was_ending = False
        while status is None:
            readable, _, _ = select.select([self._reading] if self._reading >= 0 else [], [], [], _LOOKS_EVERY)
            if readable:
                self._read()
            if self._told.ending and not was_ending:  # it has stopped stepping, and may take its time now
                was_ending, self._deadline = True, float("inf")
            if time.monotonic() > self._deadline and not self._killed:
                self._killed = True
                os.kill(self._process, signal.SIGKILL)
            done, state = os.waitpid(self._process, os.WNOHANG)
            status = os.waitstatus_to_exitcode(state) if done else None
        while self._reading >= 0 and select.select([self._reading], [], [], 0)[0]:
            self._read()
        return self._conclude(status)

    def _read(self) -> None:
        lines = os.read(self._reading, 2**16)
        if lines:
            self._told.take(lines)
        else:
            os.close(self._reading)
            self._reading = -1

    def _conclude(self, status: int) -> int:
        """Tell what the process could not tell, complete its folder, and return the exit code."""
        told = self._told
        if told.code is not None and status == told.code:
            if status and told.folder:
                _complete_if_unfinished(Path(told.folder))
            return status
        from fmus.toolchain.child_death import Death, death_in_words  # noqa: PLC0415 - only this needs them
        from orchestrator.command.console import FAULT, INTERRUPTED, err  # noqa: PLC0415

        if self._interrupted and not told.folder:
            return _interrupted()
        words = death_in_words(Death(status))
        if call := last_call(self._called):
            words += f"; the last call of an FMU in this process was `{call}`"
        err.show_cursor()
        if told.code is not None:
            text = f"the process that steps died when it was closed ({words}); the folder is complete"
            err.print(f"macrostep: {text}", style="red")
            return told.code or FAULT
        reason = f"the process that steps died ({words})"
        if self._killed:
            reason = f"the process that steps did not stop within {_STOPS_WITHIN:g} s and was ended"
        text = f"interrupted; {reason}" if self._interrupted else f"the run ended in a fault: {reason}"
        err.print(f"macrostep: {text}", style="red")
        if told.folder:
            _complete(Path(told.folder), reason, interrupted=self._interrupted)
        return INTERRUPTED if self._interrupted else FAULT


def _complete_if_unfinished(folder: Path) -> None:
    """Complete a run folder that the other process has left: a library may have taken files or memory from it."""
    from orchestrator.results.run_folder import DRAFT  # noqa: PLC0415 - only a run that failed needs it

    if (folder / DRAFT).is_file():
        _complete(folder, "the process that steps could not complete the folder", interrupted=False)


def _complete(folder: Path, reason: str, *, interrupted: bool) -> None:
    """Complete a run folder with what is on disk, and say what is in it."""
    from components.interfaces.problem import RequestError  # noqa: PLC0415 - only a run that died needs all this
    from orchestrator.command.console import err, print_problems  # noqa: PLC0415
    from orchestrator.results.completion import finish  # noqa: PLC0415

    try:
        content = finish(folder, reason, interrupted=interrupted)
    except RequestError as error:
        print_problems(error.problems)
    except OSError as error:
        err.print(
            f"macrostep: {folder}: not completed ({error.strerror}); its rows are in its folder rows", style="red"
        )
    else:
        ticks = content.get("experiment", {}).get("ticks", 0)
        err.print(f"{ticks} ticks are in {folder}/; look at it with: macrostep show {shlex.quote(str(folder))}")
