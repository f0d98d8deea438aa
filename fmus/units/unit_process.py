"""The process of an `IsolatedUnit` as the other process sees it: started, asked, and ended in any case."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from fmus.reading.archive import Archive
from fmus.reading.library import compile_beforehand
from fmus.toolchain.child_death import ChildDiedError, ChildSilentError, death_in_words
from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.foreign_text import plain
from fmus.toolchain.last_call import last_call
from fmus.toolchain.scratch import SCRATCH, scratch_folder
from fmus.toolchain.shared_counter import counters_work
from fmus.toolchain.shared_file import SharedFile
from fmus.toolchain.typed_messages import UnreadableMessageError
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
        self._columns, control = SharedFile(folder, "columns"), SharedFile(folder, "control")
        self._control = control.path if counters_work() else None
        self._block = None if self._control is None else ControlBlock(self._control)
        if self._block is not None:
            control.fix()
        self._child = ChildProcess(
            "fmus.units.isolated_process",
            UnitReply,
            dict.fromkeys(("TMPDIR", SCRATCH), str(folder)),
            shared=(*self._columns.descriptors, *control.descriptors),
        )
        control.close()
        self._unit, self._said = "", MessageLog()
        self._awaited = self._started = self._closed = False

    @property
    def columns(self) -> Path:
        """The file of the columns, until the unit is made."""
        return self._columns.path

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
        self._columns.fix()
        self._columns.close()
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
                raise self._failed(method, ChildDiedError(self._child.death()))
            if time.monotonic() >= deadline:
                self._child.kill()
                raise self._failed(method, ChildSilentError(patience))

    def _ask(self, method: str, request: Instantiation | UnitCall, patience: float) -> UnitReply:
        self._awaited = True
        try:
            self._child.send(request, patience)
        except (ChildDiedError, ChildSilentError) as error:
            raise self._failed(method, error) from error
        return self._answer(method, patience)

    def _answer(self, method: str, patience: float) -> UnitReply:
        try:
            reply = self._child.answer(patience)
        except (ChildDiedError, ChildSilentError, UnreadableMessageError) as error:
            raise self._failed(method, error) from error
        self._awaited = False
        return reply

    def _failed(self, method: str, error: Exception) -> UnitError:
        """What became of a call that has not been answered."""
        self._awaited = False
        call = f"`{self.called or method}`"
        if isinstance(error, ChildSilentError):
            action = f"no answer to {call} within {error.within:g} s; its process has been ended"
        elif isinstance(error, ChildDiedError):
            action = f"its process died in {call} ({death_in_words(error.death)})"
        else:
            action = f"its process gave an answer to {call} that is none ({plain(str(error))}), and has been ended"
        return UnitError(self._unit, action, self._said)

    @property
    def called(self) -> str:
        """The function of the FMU that its process has called last; empty if it has called none."""
        return "" if self._block is None else last_call(self._block.called)

    def close(self) -> str:
        """End the FMU, its process, and what that has started. May be called more than once.

        Returns:
            What went wrong while the FMU was released, which loses nothing of the run; empty if nothing did.
        """
        if self._closed:
            return ""
        self._closed, problem = True, ""
        try:
            self._end_in_order()
        except UnitError as error:
            problem = error.reason
        finally:
            self._columns.close()
            self._child.kill()
            self._child.close()
            if self._block is not None:
                self._block.close()
            self._folder.cleanup()
        return problem

    def _end_in_order(self) -> None:
        if not self._started or not self.is_alive:
            return
        self.call(UnitCall("close"), _CLOSING)
        death = self._child.death(_CLOSING)
        if death is None or death.code:
            how = "did not end" if death is None else f"died ({death_in_words(death)})"
            raise UnitError(self._unit, f"its process {how} when the FMU had been released", self._said)

    def _finish(self) -> None:
        """Wait a moment for the end of the call that was interrupted. Raises `UnitError`."""
        block = self._block
        if block is not None:
            self._wait(block, "step", _LEAVING)
            _, message = block.reply
            if not message:
                return
        self._answer("step", _LEAVING)
