"""The process of an `IsolatedUnit` as the other process sees it: started, asked, and ended in any case."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from fmus.reading.archive import Archive
from fmus.reading.library import compile_beforehand
from fmus.toolchain.child_death import ChildDiedError, ChildSilentError, Death, death_in_words
from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.scratch import SCRATCH, scratch_folder
from fmus.toolchain.shared_counter import counters_work
from fmus.units.control_block import ControlBlock, QuickCall, QuickRequest
from fmus.units.isolated_messages import Instantiation, UnitCall, UnitReply
from fmus.units.message_log import MessageLog
from fmus.units.unit import UnitError

_STARTING: Final = 60.0
"""[s] The time that the start of the process may take."""
_CLOSING: Final = 5.0
"""[s] The time that the FMU, and then its process, may take to end."""
_LEAVING: Final = 2.0
"""[s] The time that a call may still take that a person has interrupted."""
_SLICE: Final = 0.02
"""[s] The time after which it is looked again whether the process is alive."""

_ready: list[UnitProcess] = []


@contextmanager
def started_processes(number: int) -> Generator[None]:
    """Start processes for the units that are made in a `with` statement, so that they start at the same time."""
    try:
        _ready.extend(UnitProcess() for _ in range(number))
        yield
    finally:
        while _ready:
            _ready.pop().close()


def unit_process() -> UnitProcess:
    """A process without a unit: one that was started before, or a new one."""
    return _ready.pop(0) if _ready else UnitProcess()


class UnitProcess:
    """A process for one FMU, which is started at once; `close` has to be called at the end."""

    def __init__(self) -> None:
        self._folder = scratch_folder("unit")
        folder = Path(self._folder.name).absolute()
        self.columns = folder / "columns"
        """The file of the columns."""
        self._control = folder / "control" if counters_work() else None
        self._block = None if self._control is None else ControlBlock(self._control)
        self._child = ChildProcess("fmus.units.isolated_process", dict.fromkeys(("TMPDIR", SCRATCH), str(folder)))
        self._unit, self._said = "", MessageLog()
        self._awaited = self._started = self._closed = False

    @property
    def is_quick(self) -> bool:
        """Whether calls of every macro step need no messages."""
        return self._block is not None

    @property
    def is_alive(self) -> bool:
        """Whether the process has not ended yet."""
        return self._child.is_alive

    def instantiate(self, name: str, archive: Archive, said: MessageLog, patience: float) -> UnitReply:
        """Make the unit of an FMU.

        Args:
            name: Its name in messages.
            archive: The FMU file.
            said: The messages of the unit, which go with those on its process.
            patience: The time that it may take [s] when the process has started; no compilation is part of it.

        Raises:
            RequestError: The sources of its library do not compile.
            UnitError: The process died, or took too long.
        """
        self._unit, self._said = name, said
        compile_beforehand(archive)
        request = Instantiation.of(name, archive, self.columns, self._control)
        self._answer("instantiate", _STARTING)
        reply = self._ask("instantiate", request, patience)
        self._started = True
        return reply

    def call(self, call: UnitCall, patience: float) -> UnitReply:
        """Have a method called. Raises `UnitError` if the process dies, or takes longer than `patience` [s]."""
        if self._awaited:  # the call before was interrupted
            self._finish()
        if self._block is not None:
            self._block.request(QuickRequest(QuickCall.MESSAGE))
        return self._ask(call.method, call, patience)

    def call_quickly(self, request: QuickRequest, patience: float) -> int | UnitReply:
        """Have a method of every macro step called; gives its status, or a reply with more than that.

        Raises:
            UnitError: The process died, or took longer than `patience` [s].
        """
        block = self._block
        if block is None:
            raise TypeError("a quick call without shared memory")
        self._awaited = True
        block.request(request)
        if not block.is_answered(_SLICE):
            self._wait(block, request.call.method, patience)
        status, message = block.reply
        if message:
            return self._answer(request.call.method, patience)
        self._awaited = False
        return status

    def _wait(self, block: ControlBlock, method: str, patience: float) -> None:
        """Wait for the reply to a quick call."""
        deadline = time.monotonic() + patience
        while not block.is_answered(_SLICE):
            if not self.is_alive and not block.is_answered(0.0):
                self._awaited = False
                raise self._died(method, self._child.death())
            if time.monotonic() >= deadline:
                self._awaited = False
                self._child.kill()
                raise self._silent(method, patience)

    def _ask(self, method: str, request: Instantiation | UnitCall, patience: float) -> UnitReply:
        self._awaited = True
        try:
            self._child.send(request)
        except ChildDiedError as error:
            self._awaited = False
            raise self._died(method, error.death) from error
        return self._answer(method, patience)

    def _answer(self, method: str, patience: float) -> UnitReply:
        try:
            reply: UnitReply = self._child.answer(patience)
        except ChildSilentError as silence:
            self._awaited = False
            raise self._silent(method, patience) from silence
        except ChildDiedError as error:
            self._awaited = False
            raise self._died(method, error.death) from error
        self._awaited = False
        return reply

    def _silent(self, method: str, patience: float) -> UnitError:
        return UnitError(
            self._unit, f"no answer to `{method}` within {patience:g} s; its process has been ended", self._said
        )

    def _died(self, method: str, death: Death | None) -> UnitError:
        return UnitError(self._unit, f"its process died in `{method}` ({death_in_words(death)})", self._said)

    def close(self) -> None:
        """End the FMU, its process, and what that has started. May be called more than once."""
        if self._closed:
            return
        self._closed = True
        try:
            self._end_in_order()
        except UnitError:
            pass  # nothing is lost: the run has all its values
        finally:
            self._child.kill()
            self._child.close()
            if self._block is not None:
                self._block.close()
            self._folder.cleanup()

    def _end_in_order(self) -> None:
        if not self._started or not self.is_alive:
            return
        self.call(UnitCall("close"), _CLOSING)
        self._child.death(_CLOSING)

    def _finish(self) -> None:
        """Wait a moment for the end of the call that was interrupted. Raises `UnitError`."""
        block = self._block
        if block is not None:
            self._wait(block, "step", _LEAVING)
            _, message = block.reply
            if not message:
                return
        self._answer("step", _LEAVING)
