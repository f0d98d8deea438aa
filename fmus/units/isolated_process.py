"""The process of an `IsolatedUnit`: it holds one FMU and carries out one call at a time."""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Callable
from functools import partial
from typing import Any

from typing_extensions import override

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type
from fmus.reading.observation import observing
from fmus.reading.opening import open_fmu
from fmus.toolchain.child_process import ParentProcess
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.isolated_messages import Instantiation, UnitCall, UnitReply, map_columns, put_texts, texts
from fmus.units.make import fmu_unit
from fmus.units.unit import FMI_WARNING, Column, EndRequested, Unit, UnitError, carry_out


def main() -> None:
    """Answer requests until the unit is closed, or the parent process has ended."""
    parent = ParentProcess()
    host: _Host | None = None
    while True:
        try:
            request: Instantiation | UnitCall = pickle.load(parent.requests)  # noqa: S301 - from our own process
        except (EOFError, pickle.UnpicklingError):
            return
        try:
            if isinstance(request, Instantiation):
                host, reply = _Host(request), UnitReply()
            else:
                reply = UnitReply() if host is None else host.carry_out(request)
        except RequestError as error:
            reply = UnitReply(problems=error.problems)
        except UnitError as error:
            reply = UnitReply(fault=(error.action, error.said))
        parent.answer(reply)
        if isinstance(request, UnitCall) and request.method == "close":
            return


class _Host:
    """The unit, its columns, and the methods that may be called."""

    def __init__(self, request: Instantiation) -> None:
        opened = open_fmu(
            request.path, request.parameters, lenient=request.lenient, interface_type=request.interface_type
        )
        archive = observing(opened, request.observed, request.parameters)
        self._unit = fmu_unit(request.name, archive)
        self._inputs, self._outputs = map_columns(archive.interface, request.memory)
        self._methods = _methods(self._unit, self._inputs, self._outputs)

    def carry_out(self, call: UnitCall) -> UnitReply:
        """Call a method of the unit. Raises `UnitError` and `RequestError` as the method does."""
        unit = self._unit
        put_texts(self._inputs, call.texts)
        status = carry_out(unit.setters()) if call.set_first else 0
        value, end = None, None
        if status <= FMI_WARNING:
            try:
                value = self._methods[call.method](*call.arguments)
            except EndRequested as ended:
                end = ended.time
        if call.get_after and status <= FMI_WARNING:
            status = carry_out(unit.getters())
        if status > FMI_WARNING and not value:
            value = status
        messages, remarks = tuple(unit.messages), tuple(unit.remarks)
        unit.messages.clear()
        unit.remarks.clear()
        return UnitReply(value, messages, texts(self._outputs), remarks=remarks, end=end)


def _methods(unit: Unit, inputs: dict[Type, Column], outputs: dict[Type, Column]) -> dict[str, Callable[..., Any]]:
    """The calls that a unit can be requested to make, by the names that messages use."""
    methods: dict[str, Callable[..., Any]] = {
        "bind": partial(unit.bind, inputs, outputs),
        "enter_initialization": unit.enter_initialization,
        "exit_initialization": unit.exit_initialization,
        "step": unit.step,
        "tune": unit.tune,
        "terminate": unit.terminate,
        "get": lambda: None,  # only the outputs are requested
        "close": unit.close,
    }
    if (events := unit.events) is not None:
        methods |= {"use_events": partial(_use_events, events)}
        methods |= {"activate": events.activate, "update": events.update}
        methods |= {"fired": events.fired, "trigger": events.trigger}
    if unit.state is not None:
        saved = _SavedStates(unit.state)
        methods |= {"save": saved.save, "restore": saved.restore, "forget": saved.forget}
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


if __name__ == "__main__":
    main()
