"""An FMU in a process of its own: if it crashes or hangs, the run ends with a message, and this process survives.

It costs the start of a process and, where there is shared memory to wait for, about ten microseconds per macro step;
elsewhere, and for texts and bytes, an exchange of messages. Outputs that are shown without a step cost another one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Final

from typing_extensions import override

from fmus.reading.archive import Archive
from fmus.toolchain.foreign_text import plain
from fmus.toolchain.limits import PATIENCE
from fmus.toolchain.typed_messages import UnreadableMessageError
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.control_block import QuickCall, QuickRequest
from fmus.units.isolated_messages import UnitCall, UnitReply, map_columns, put_texts, texts
from fmus.units.unit import DEFAULT_SETUP, Column, ExperimentSetup, Operation, TypedColumns, Unit, UnitError
from fmus.units.unit_process import unit_process

_LONGEST_REMARK: Final = 4000
"""[characters] A remark, whose foreign parts are bounded before."""


class IsolatedUnit(Unit):
    """An FMU in another process.

    Args:
        name: Name of the unit.
        archive: The FMU file, as it was read: with the values that decide the lengths of arrays.
        patience: The time that a call may take [s]; a call that takes longer ends the process.

    Raises:
        RequestError: The FMU cannot be instantiated.
        UnitError: The process died or hung during its start.
    """

    def __init__(self, name: str, archive: Archive, patience: float = PATIENCE) -> None:
        super().__init__(name, archive.interface)
        self._patience = patience
        self._inputs: list[tuple[Column, Column]] = []
        self._outputs: list[tuple[Column, Column]] = []
        self._unset: frozenset[str] | None = None
        self._inputs_sent, self._outputs_current = True, False
        self._process = unit_process()
        self.called = lambda: self._process.called
        try:
            self._their_inputs, self._their_outputs = map_columns(archive.interface, self._process.columns)
            demanded = self._received(self._process.instantiate(name, archive, self.messages, patience))
        except BaseException:
            self.close()
            raise
        numbers = all(kind.is_number for kind in (*self._their_inputs, *self._their_outputs))
        self._quick = numbers and self._process.is_quick
        self.events = _IsolatedEvents(self._call, self._call_timed) if archive.interface.event_mode else None
        if self.events is not None:
            self.events.demanded = bool(demanded)
        if archive.interface.rolls_back:
            serializes = bool(archive.interface_type.canSerializeFMUstate)
            self.state = _IsolatedState(self._call, serializes=serializes)

    def _received(self, reply: UnitReply) -> Any:
        """Take over what a reply contains, and give its value. Raises what the FMU's unit raised."""
        for text, status in reply.messages:
            self.messages.append(text, status)
        self.warnings = reply.warnings
        for remark in reply.remarks:
            self.remark(plain(remark, _LONGEST_REMARK))
        try:
            put_texts(self._their_outputs, reply.texts)
        except UnreadableMessageError as error:
            raise UnitError(self.name, f"its process gave {error}", self.messages) from error
        if reply.raised is not None:
            raise reply.raised.error(self.name)
        return reply.value

    def _call(self, method: str, *arguments: Any, show: bool = False) -> Any:
        """Call a method of the FMU's unit, which is given the inputs first if they have changed."""
        sent, self._inputs_sent = self._inputs_sent, True
        self._outputs_current = show
        call = UnitCall(method, arguments, not sent, show, [] if sent else texts(self._their_inputs))
        return self._received(self._process.call(call, self._patience))

    def _call_timed(self, call: QuickCall, t: float = 0.0, h: float = 0.0, *, show: bool = False) -> object:
        """Call a method that is called in every macro step, likewise."""
        if not self._quick:
            return self._call(call.method, *(() if call is QuickCall.GET else (t, h)), show=show)
        request = QuickRequest(call, not self._inputs_sent, show, t, h)
        self._inputs_sent, self._outputs_current = True, show
        reply = self._process.call_quickly(request, self._patience)
        return reply if isinstance(reply, int) else self._received(reply)

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        self._inputs = [(self._their_inputs[kind], column) for kind, column in inputs.items()]
        self._outputs = [(column, self._their_outputs[kind]) for kind, column in outputs.items()]
        if self._unset != frozenset(unset):  # the child's unit keeps the shared columns whatever this one is bound to
            self._unset = frozenset(unset)
            self._call("bind", self._unset)

    def _take(self) -> object:
        for theirs, ours in self._inputs:
            theirs[:] = ours
        self._inputs_sent = self._outputs_current = False
        return 0

    def _show(self) -> object:
        status = 0 if self._outputs_current else self._call_timed(QuickCall.GET, show=True)
        for ours, theirs in self._outputs:
            ours[:] = theirs
        return status or 0

    @override
    def setters(self) -> list[Operation]:
        return [self._take]

    @override
    def getters(self) -> list[Operation]:
        return [self._show]

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], setup: ExperimentSetup = DEFAULT_SETUP) -> None:
        self._call("enter_initialization", dict(parameters), setup)

    @override
    def exit_initialization(self) -> None:
        self._call("exit_initialization", show=True)
        self._show()

    @override
    def step(self, t: float, h: float) -> object:
        return self._call_timed(QuickCall.STEP, t, h, show=True)

    @override
    def tune(self, parameter: str, value: Any) -> None:
        self._call("tune", parameter, value)

    @override
    def terminate(self) -> None:
        self._call("terminate")

    @override
    def reset(self) -> None:
        self._call("reset")
        self._unset, self._inputs_sent, self._outputs_current = None, True, False
        self._forget_calls()

    @override
    def close(self) -> None:
        if problem := self._process.close():
            self.remark(problem)


class _IsolatedEvents(EventCapability):
    """Event Mode of the FMU in the other process, by calls of its methods there."""

    def __init__(self, call: Callable[..., Any], call_timed: Callable[[QuickCall, float, float], object]) -> None:
        self._call, self._call_timed = call, call_timed

    @override
    def use(self, h: float, *, settles: bool = False) -> None:
        self._call("use_events", h, settles)

    @override
    def activate(self, t: float, h: float) -> object:
        return self._call_timed(QuickCall.ACTIVATE, t, h)

    @override
    def update(self, t: float, h: float) -> object:
        return self._call_timed(QuickCall.UPDATE, t, h)

    @override
    def fired(self) -> set[str]:
        return set(self._call("fired"))

    @override
    def trigger(self, clock: str) -> None:
        self._call("trigger", clock)


class _IsolatedState(StateCapability):
    """The state of the FMU in the other process, which keeps all that is saved."""

    def __init__(self, call: Callable[..., Any], *, serializes: bool) -> None:
        self._call, self.serializes = call, serializes

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
    def serialized(self, state: Any) -> bytes:
        return bytes(self._call("serialized", state))

    @override
    def deserialized(self, content: bytes) -> Any:
        return self._call("deserialized", content)
