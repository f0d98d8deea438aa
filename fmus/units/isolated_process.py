"""The process of an `IsolatedUnit`: it holds one FMU and carries out one call at a time."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from functools import partial
from typing import Any, Final

from typing_extensions import override

from components.interfaces.quantity import Type
from fmus.reading.kept_files import sharing
from fmus.toolchain.child_process import ParentProcess
from fmus.toolchain.last_call import note_calls
from fmus.toolchain.sealed_messages import MessageSizeError
from fmus.toolchain.shared_file import let_go
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.control_block import ControlBlock, QuickCall, QuickRequest
from fmus.units.isolated_messages import Instantiation, Raised, UnitCall, UnitReply, map_columns, put_texts, texts
from fmus.units.make import fmu_unit
from fmus.units.unit import FMI_WARNING, Column, EndRequested, Unit, carry_out, is_failure

_OF_UNITS: Final = ("enter_initialization", "exit_initialization", "step", "tune", "terminate", "close")
_OF_EVENTS: Final = ("activate", "update", "fired", "trigger")
_OF_STATES: Final = ("save", "restore", "forget", "serialized", "deserialized")
"""The methods that can be called from the other process."""


def main() -> None:
    """Answer requests until the unit is closed, or the parent process has ended."""
    parent = ParentProcess()
    parent.end_with_parent()
    try:
        parent.answer(UnitReply())  # that it has started
        request: Instantiation = parent.request()
        host = _made(parent, request)
        if host is not None:
            _serve(parent, *host)
    except EOFError:  # the parent has ended
        return


def _made(parent: ParentProcess, request: Instantiation) -> tuple[_Host, ControlBlock | None] | None:
    """Make the unit, and say so."""
    os.chdir(request.folder)  # paths are relative to it, and files that an FMU makes belong there
    try:
        block = None if request.control is None else ControlBlock(request.control)
        if block is not None:
            note_calls(block.called)
        if request.control is not None:
            let_go(request.control)
        host = _Host(request)
    except Exception as error:  # noqa: BLE001 - whatever an FMU leads to is told by the other process
        parent.answer(UnitReply(raised=Raised.of(error)))
        return None
    _answer(parent, host.reply(host.demands_events))
    return host, block


def _serve(parent: ParentProcess, host: _Host, block: ControlBlock | None) -> None:
    """Carry out requests until the unit is closed. Raises `EOFError`."""
    closed = False
    while not closed:
        quick = None if block is None else block.next_request()
        if block is not None and quick is not None and quick.call is not QuickCall.MESSAGE:
            reply = host.carry_out_quickly(quick)
            if isinstance(reply, int):
                block.answer(reply)
            else:
                block.answer(message=True)
                _answer(parent, reply)
            continue
        call: UnitCall = parent.request()
        reply = host.carry_out(call)
        closed = call.method == "close"
        if block is not None:
            block.answer(message=True)
        _answer(parent, reply)


def _answer(parent: ParentProcess, reply: UnitReply) -> None:
    """Answer, or say that the answer is too large. Raises `EOFError`."""
    try:
        parent.answer(reply)
    except MessageSizeError as error:
        parent.answer(UnitReply(raised=Raised(f"its outputs are {error}")))


class _Host:
    """The unit, its columns, and the methods that may be called."""

    def __init__(self, request: Instantiation) -> None:
        archive = request.archive
        self._inputs, self._outputs = map_columns(archive.interface, request.memory)  # before it can close anything
        let_go(request.memory)
        self._unit = fmu_unit(request.name, sharing(archive))
        self._methods = _methods(self._unit, self._inputs, self._outputs)
        self._methods["reset"] = self._reset
        self._of_opening, self._told = len(self._unit.remarks), 0
        """The number of remarks when the unit was made, and of those that have been sent."""
        self._quick = {call: self._methods[call.method] for call in QuickCall if call.method in self._methods}

    @property
    def demands_events(self) -> bool:
        """Whether the unit runs with Event Mode only."""
        return self._unit.events is not None and self._unit.events.demanded

    def reply(self, value: Any = None, raised: Exception | None = None) -> UnitReply:
        """The reply with a value, or with what was raised, and with all that has not been sent yet."""
        unit = self._unit
        messages, remarks = tuple(unit.messages), tuple(unit.remarks[self._told :])
        unit.messages.clear()
        self._told = len(unit.remarks)
        error = None if raised is None else Raised.of(raised)
        return UnitReply(value, messages, remarks, unit.warnings, texts(self._outputs), error)

    def _reset(self) -> None:
        self._unit.reset()
        del self._unit.remarks[self._of_opening :]
        self._told = self._of_opening

    def carry_out(self, call: UnitCall) -> UnitReply:
        """Call a method of the unit."""
        put_texts(self._inputs, call.texts)
        try:
            return self.reply(
                self._between(call.set_first, call.get_after, self._methods[call.method], *call.arguments)
            )
        except Exception as error:  # noqa: BLE001 - as above
            return self.reply(raised=error)

    def carry_out_quickly(self, request: QuickRequest) -> int | UnitReply:
        """Call one of the methods of every macro step; where there is more to say than that it is done, a reply."""
        call, set_first, get_after, t, h = request
        times = () if call is QuickCall.GET else (t, h)
        try:
            value = self._between(set_first, get_after, self._quick[call], *times)
        except Exception as error:  # noqa: BLE001 - as above
            return self.reply(raised=error)
        # Messages about what went well can wait: many FMUs write one in every step.
        return self.reply(value) if value or len(self._unit.remarks) > self._told else 0

    def _between(self, set_first: bool, get_after: bool, method: Callable[..., Any], *arguments: Any) -> Any:  # noqa: FBT001
        """Call a method between the setters and the getters of the unit; give its value, or the status of a failure.

        A unit that asks for the end of the run may still be read.
        """
        unit, value, asked = self._unit, None, None
        if set_first and (status := carry_out(unit.setters())) and (status := self._heard(status)):
            return status
        try:
            if (value := method(*arguments)) and method in self._quick.values():
                value = self._heard(value)
        except EndRequested as end:
            asked = end
        if value and is_failure(value):
            return value
        if get_after and (status := carry_out(unit.getters())) and not value:
            value = self._heard(status)
        if asked is not None:
            raise asked
        return value

    def _heard(self, value: Any) -> Any:
        """What a call gave, without a warning, which the unit tells."""
        self._unit.warned(value)
        return None if value == FMI_WARNING else value


def _methods(unit: Unit, inputs: dict[Type, Column], outputs: dict[Type, Column]) -> dict[str, Callable[..., Any]]:
    """The calls that a unit can be requested to make, by the names that messages use."""
    methods: dict[str, Callable[..., Any]] = {name: getattr(unit, name) for name in _OF_UNITS}
    methods["bind"] = partial(unit.bind, inputs, outputs)
    methods["get"] = lambda: None  # only the outputs are requested
    if unit.events is not None:
        methods |= {name: getattr(unit.events, name) for name in _OF_EVENTS} | {
            "use_events": partial(_use_events, unit.events)
        }
    if unit.state is not None:
        saved = _SavedStates(unit.state)
        methods |= {name: getattr(saved, name) for name in _OF_STATES}
    return methods


def _use_events(events: EventCapability, h: float, settles: bool) -> None:  # noqa: FBT001 - from a message
    events.use(h, settles=settles)


class _SavedStates(StateCapability):
    """Saved states, which stay in this process; the other process receives a number for each."""

    def __init__(self, state: StateCapability) -> None:
        self._state = state
        self._saved: dict[int, Any] = {}
        self._numbers = itertools.count(1)

    @override
    def save(self) -> Any:
        number = next(self._numbers)
        self._saved[number] = self._state.save()
        return number

    @override
    def restore(self, state: Any) -> None:
        self._state.restore(self._saved[state])

    @override
    def forget(self, state: Any) -> None:
        self._state.forget(self._saved.pop(state))

    @override
    def serialized(self, state: Any) -> bytes:
        return self._state.serialized(self._saved[state])

    @override
    def deserialized(self, content: bytes) -> Any:
        number = next(self._numbers)
        self._saved[number] = self._state.deserialized(content)
        return number


if __name__ == "__main__":
    main()
