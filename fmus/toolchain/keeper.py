"""The process between a child and its parent: it runs the child's module in a copy of itself, and ends what stays.

When the child or the parent ends, everything that the child has started ends too, also what has left its session:
Linux gives processes whose parents have ended to this one. What the child prints passes through here, as plain text and
to a limit. The exit code is that of the child. `python -m fmus.toolchain.keeper MODULE [outlives]`; with the second
word the child goes on without its parent. Systems other than Linux run the module itself.
"""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
import os
import runpy
import select
import signal
import sys
import time
from codecs import getincrementaldecoder
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from fmus.toolchain.foreign_text import printed
from fmus.toolchain.limits import LARGEST_OUTPUT

FAMILY: Final = "MACROSTEP_FAMILY"
"""The environment variable that tells what a child has started, whatever became of its keeper."""
_DEATH_SIGNAL, _ADOPTS = 1, 36
"""Numbers of the system call `prctl`: a signal when the parent ends; to adopt orphans."""
_SWEEPS: Final = 10
"""How often it is looked for what a child has started; a process may start another while it is looked for."""
_LEAVES: Final = 2.0
"""[s] The time that the child has to end when its parent has ended."""
_ENDS: Final = 10.0
"""[s] The time after which processes are left that do not end although they have been killed."""
_READS: Final = 1.0
"""[s] The time that whoever reads what the child prints may keep it waiting."""
_IGNORED: Final = ("SIGINT", "SIGHUP", "SIGQUIT", "SIGPIPE", "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGTSTP", "SIGTTOU")


def main() -> None:
    """Run the module."""
    _, module, *outlives = sys.argv
    if sys.platform == "linux":
        _divide(outlives=bool(outlives))
    sys.argv = [module]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


def _divide(*, outlives: bool) -> None:
    """Make the copy that goes on; this process keeps it, and does not return."""
    system = ctypes.CDLL(None)
    system.prctl(_ADOPTS, 1, 0, 0, 0)
    keeper, (output, printed_to), (wakes, wake) = os.getpid(), os.pipe(), os.pipe()
    os.set_blocking(wake, False)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGCHLD})
    child = os.fork()
    if child:
        os.close(printed_to)
        _Keeper(child, output, outlives=outlives).keep(wakes, wake, mask)
    for descriptor in (output, wakes, wake):
        os.close(descriptor)
    os.dup2(printed_to, 2)
    os.close(printed_to)
    os.setsid()  # a signal to its whole group does not reach this process's keeper
    system.prctl(_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)
    with suppress(OSError):  # it is the first to go where memory ends
        Path("/proc/self/oom_score_adj").write_text("1000", "ascii")
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    if os.getppid() != keeper:
        os._exit(1)


class _Keeper:
    """What the keeper does until the child has ended."""

    def __init__(self, child: int, output: int, *, outlives: bool) -> None:
        self._child, self._output, self._outlives = child, output, outlives
        self._status: int | None = None
        self._left = LARGEST_OUTPUT
        self._decoder = getincrementaldecoder("utf-8")("replace")

    def keep(self, wakes: int, wake: int, mask: Iterable[int]) -> None:
        """Wait for the end of the child or the parent, then end what stays, and end as the child did."""
        for name in _IGNORED:
            signal.signal(getattr(signal, name), signal.SIG_IGN)
        for number in (signal.SIGTERM, signal.SIGCHLD):
            signal.signal(number, lambda *_: None)
        signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)  # nobody waits for answers when the child has ended
        os.set_blocking(self._output, False)
        self._wait(wakes)
        self._end_all()
        self._pass_on()
        _end_as(self._status)

    def _wait(self, wakes: int) -> None:
        poll = select.poll()
        for descriptor, events in ((wakes, select.POLLIN), (self._output, select.POLLIN), (0, 0)):
            poll.register(descriptor, events)
        until = float("inf")
        while self._status is None and time.monotonic() < until:
            for descriptor, _ in poll.poll(None if until == float("inf") else 100):
                if descriptor == wakes and signal.SIGTERM in os.read(wakes, 1000):
                    return
                if descriptor == self._output and not self._pass_on():
                    poll.unregister(descriptor)
                if descriptor == 0:  # the parent has ended, or has nothing more to ask
                    poll.unregister(0)
                    until = until if self._outlives else time.monotonic() + _LEAVES
            self._reap()

    def _reap(self) -> bool:
        """Take note of the processes that have ended; gives whether there are others."""
        with suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                if ended[0] == self._child:
                    self._status = ended[1]
            return True
        return False

    def _end_all(self) -> None:
        """End every process that this one has, until there is none; orphans come to it one after the other."""
        until = time.monotonic() + _ENDS
        while self._reap() and time.monotonic() < until:
            with suppress(OSError):
                os.killpg(self._child, signal.SIGKILL)
            for process in _children():
                with suppress(OSError):
                    os.kill(process, signal.SIGKILL)
            time.sleep(0.001)

    def _pass_on(self) -> bool:
        """Pass on what the child has printed; gives whether more may come."""
        try:
            while data := os.read(self._output, 1 << 16):
                self._print(data)
        except BlockingIOError:
            return True
        return False

    def _print(self, data: bytes) -> None:
        if self._left <= 0:
            return
        text = printed(self._decoder.decode(data[: self._left]))
        self._left -= len(data)
        if self._left <= 0:
            text += "\n(the rest of what it prints is left out)\n"
        if select.select([], [2], [], _READS)[1]:  # nobody may read it
            with suppress(OSError):
                os.write(2, text.encode())


def _children() -> list[int]:
    """The processes of which this one is the parent."""
    with suppress(OSError):
        return [int(n) for n in Path(f"/proc/self/task/{os.getpid()}/children").read_text("ascii").split()]
    return []


def end_family(family: str) -> None:
    """End the processes that were started by a child whose keeper is gone; they are told by their environment."""
    mark = f"{FAMILY}={family}".encode()
    for _ in range(_SWEEPS):
        found = False
        for environment in Path("/proc").glob("[0-9]*/environ"):
            with suppress(OSError, ValueError):  # it has ended, or belongs to somebody else
                if mark in environment.read_bytes().split(b"\0"):
                    os.kill(int(environment.parent.name), signal.SIGKILL)
                    found = True
        if not found:
            return


def _end_as(status: int | None) -> None:
    """End as the child did: with its exit code, or by the same signal."""
    if status is not None and os.WIFSIGNALED(status):
        import resource  # noqa: PLC0415 - only then

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # the child has written one, if it is wanted
        number = os.WTERMSIG(status)
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    os._exit(1 if status is None else os.WEXITSTATUS(status))


if __name__ == "__main__":
    main()
