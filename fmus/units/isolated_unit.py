"""An FMU in a process of its own: one that dies or hangs ends the run with a message, and takes nothing along.

It costs a start of a process, and one exchange per macro step; outputs that are shown without a step are another one.
"""

from __future__ import annotations

import mmap
import pickle
import select
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from multiprocessing import Pipe
from os import environ
from typing import Any, Final

from typing_extensions import override

from components.interfaces.problem import raise_if_any
from components.interfaces.quantity import Type
from fmus.reading.archive import Archive
from fmus.units.isolated_process import Answer, Request, columns, put_texts, size, texts
from fmus.units.unit import Column, Operation, Unit, UnitError

PATIENCE: Final = 30.0
"""[s] that a call may take unless something else is said"""
_STARTING: Final = 60.0
"""[s] that the start of the process and of the FMU may take"""


class IsolatedUnit(Unit):
    """The FMU in `archive`, in another process; a call that takes more than `patience` seconds ends it."""

    def __init__(
        self,
        name: str,
        archive: Archive,
        parameters: Mapping[str, Any],
        *,
        lenient: bool = False,
        patience: float = PATIENCE,
    ) -> None:
        super().__init__(name, archive.interface)
        self._patience = patience
        self._folder = tempfile.TemporaryDirectory(prefix="macrostep_")  # what it unpacks goes with it, however it ends
        with tempfile.TemporaryFile() as file:
            file.truncate(size(archive.interface))
            self._memory = mmap.mmap(file.fileno(), size(archive.interface))
            self._pipe, theirs = Pipe()
            handed = (theirs.fileno(), file.fileno())
            # a session of its own: Ctrl-C is for the run; what the FMU prints is not what the run prints
            self._process = subprocess.Popen(  # noqa: S603 - our own interpreter
                [sys.executable, "-c", f"from fmus.units.isolated_process import serve; serve{handed}"],
                pass_fds=handed,
                stdin=subprocess.DEVNULL,
                stdout=sys.__stderr__,
                env={**environ, "TMPDIR": self._folder.name},
                start_new_session=True,
            )
            theirs.close()
        self._poll = select.poll()
        self._poll.register(self._pipe.fileno(), select.POLLIN)
        self._theirs = columns(archive.interface, self._memory)
        self._mine: list[Mapping[Type, Column]] = [{}, {}]
        self._taken, self._shown = True, False
        try:
            self._ask(Request("instantiate", (name, archive.path, dict(parameters), lenient)), _STARTING)
        except BaseException:
            self.close()
            raise

    def _ask(self, request: Request, patience: float | None = None) -> Any:
        """Send a request and wait for what came of it. Raises `UnitError` and `RequestError` as the FMU does."""
        limit = self._patience if patience is None else patience
        try:
            self._pipe.send_bytes(pickle.dumps(request))
            if not self._poll.poll(limit * 1000):
                self._process.kill()
                found = f"no answer to `{request.method}` within {limit:g} s; its process has been ended"
                raise UnitError(self.name, found, self.messages)
            answer: Answer = pickle.loads(self._pipe.recv_bytes())  # noqa: S301 - from a process of ours
        except (EOFError, OSError) as error:
            found = f"its process died in `{request.method}` ({self._death()})"
            raise UnitError(self.name, found, self.messages) from error
        self.messages.extend(answer.messages)
        raise_if_any(answer.problems)
        if answer.fault is not None:
            raise UnitError(self.name, *answer.fault)
        put_texts(self._theirs[1], answer.texts)
        return answer.value

    def _death(self) -> str:
        try:
            code = self._process.wait(5)
        except subprocess.TimeoutExpired:
            return "it closed the pipe"
        return signal.Signals(-code).name if code < 0 else f"exit code {code}"

    def _call(self, method: str, *arguments: Any, show: bool = False) -> Any:
        taken, self._taken = self._taken, True
        self._shown = show
        return self._ask(Request(method, arguments, not taken, show, [] if taken else texts(self._theirs[0])))

    @override
    def bind(self, inputs: Mapping[Type, Column], outputs: Mapping[Type, Column]) -> None:
        first = not self._mine[0] and not self._mine[1]
        self._mine = [inputs, outputs]
        if first:
            self._call("bind")

    def _take(self) -> object:
        for kind, column in self._mine[0].items():
            self._theirs[0][kind][:] = column
        self._taken = self._shown = False
        return 0

    def _show(self) -> object:
        status = 0 if self._shown else self._call("get", show=True)
        for kind, column in self._mine[1].items():
            column[:] = self._theirs[1][kind]
        return status or 0

    @override
    def setters(self) -> list[Operation]:
        return [self._take]

    @override
    def getters(self) -> list[Operation]:
        return [self._show]

    @override
    def enter_initialization(self, parameters: Mapping[str, Any]) -> None:
        self._call("enter_initialization", dict(parameters))

    @override
    def exit_initialization(self) -> None:
        self._call("exit_initialization", show=True)
        self._show()

    @override
    def step(self, t: float, h: float) -> object:
        return self._call("step", t, h, show=True)

    @override
    def use_events(self, h: float) -> None:
        self._call("use_events", h)

    @override
    def activate(self, t: float, h: float) -> object:
        return self._call("activate", t, h)

    @override
    def update(self, t: float, h: float) -> object:
        return self._call("update", t, h)

    @override
    def fired(self) -> set[str]:
        return self._call("fired")

    @override
    def trigger(self, clock: str) -> None:
        self._call("trigger", clock)

    @override
    def save(self) -> Any:
        return self._call("save")

    @override
    def restore(self, state: Any) -> None:
        self._call("restore", state)

    @override
    def forget(self, state: Any) -> None:
        self._call("forget", state)

    @override
    def close(self) -> None:
        if self._pipe.closed:
            return
        if self._process.poll() is None:
            try:
                self._ask(Request("close"), 5.0)
                self._process.wait(5)
            except (UnitError, subprocess.TimeoutExpired):
                self._process.kill()
        self._process.wait()
        self._pipe.close()
        self._folder.cleanup()
