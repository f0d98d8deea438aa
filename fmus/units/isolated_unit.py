"""An FMU in a process of its own: if it crashes or hangs, the run ends with a message, and this process survives.

It costs the start of a process, and one exchange of messages per macro step; outputs that are shown without a step cost
another one.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, Final

from typing_extensions import override

from components.interfaces.problem import raise_if_any
from fmus.reading.archive import Archive
from fmus.toolchain.child_process import ChildDiedError, ChildProcess, ChildSilentError, Death
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.isolated_messages import Instantiation, UnitCall, UnitReply, map_columns, put_texts, texts
from fmus.units.unit import WHOLE_TIME, EndRequested, Horizon, Operation, TypedColumns, Unit, UnitError

PATIENCE: Final = 30.0
"""[s] The time that a call may take by default."""
_STARTING: Final = 60.0
"""[s] The time that the start of the process and of the FMU may take."""
_CLOSING: Final = 5.0
"""[s] The time that the FMU, and then its process, may take to end."""


class IsolatedUnit(Unit):
    """An FMU in another process.

    Args:
        name: Name of the unit.
        archive: The FMU file.
        parameters: The values that decide the lengths of arrays, and any others.
        lenient: Whether broken rules of FMI are overlooked that do not keep the FMU from running.
        patience: The time that a call may take [s]; a call that takes longer ends the process.

    Raises:
        RequestError: The FMU cannot be instantiated.
        UnitError: The process died or hung during its start.
    """

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
        self._folder = tempfile.TemporaryDirectory(prefix="macrostep_")  # the child unpacks its files here, too
        memory = Path(self._folder.name, "columns")
        self._their_inputs, self._their_outputs = map_columns(archive.interface, memory)
        self._inputs: TypedColumns = {}
        self._outputs: TypedColumns = {}
        self._closed = False
        self._unset: frozenset[str] | None = None
        self._inputs_sent, self._outputs_current = True, False
        self._child = ChildProcess("fmus.units.isolated_process", {"TMPDIR": self._folder.name})
        try:
            observed = tuple(v.name for v in archive.interface.observed)
            request = Instantiation(name, archive.path, dict(parameters), lenient, archive.chosen, memory, observed)
            self._exchange("instantiate", request, _STARTING)
        except BaseException:
            self.close()
            raise
        self.events = _IsolatedEvents(self._call) if archive.interface.event_mode else None
        self.state = _IsolatedState(self._call) if archive.interface.rolls_back else None

    def _exchange(self, method: str, request: Instantiation | UnitCall, patience: float) -> Any:
        """Send a request and wait for the reply. Raises `UnitError` and `RequestError` as the FMU does."""
        try:
            reply: UnitReply = self._child.ask(request, patience)
        except ChildSilentError as silence:
            action = f"no answer to `{method}` within {silence.within:g} s; its process has been ended"
            raise UnitError(self.name, action, self.messages) from silence
        except ChildDiedError as error:
            action = f"its process died in `{method}` ({_in_words(error.death)})"
            raise UnitError(self.name, action, self.messages) from error
        self.messages.extend(reply.messages)
        self.remarks.extend(reply.remarks)
        raise_if_any(reply.problems)
        if reply.fault is not None:
            raise UnitError(self.name, *reply.fault)
        put_texts(self._their_outputs, reply.texts)
        if reply.end is not None:
            raise EndRequested(self.name, reply.end)
        return reply.value

    def _call(self, method: str, *arguments: Any, show: bool = False) -> Any:
        """Call a method of the FMU's unit, which is given the inputs first if they have changed."""
        sent, self._inputs_sent = self._inputs_sent, True
        self._outputs_current = show
        call = UnitCall(method, arguments, not sent, show, [] if sent else texts(self._their_inputs))
        return self._exchange(method, call, self._patience)

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        self._inputs, self._outputs = inputs, outputs
        if self._unset != frozenset(unset):  # the child's unit keeps the shared columns whatever this one is bound to
            self._unset = frozenset(unset)
            self._call("bind", self._unset)

    def _take(self) -> object:
        for kind, column in self._inputs.items():
            self._their_inputs[kind][:] = column
        self._inputs_sent = self._outputs_current = False
        return 0

    def _show(self) -> object:
        status = 0 if self._outputs_current else self._call("get", show=True)
        for kind, column in self._outputs.items():
            column[:] = self._their_outputs[kind]
        return status or 0

    @override
    def setters(self) -> list[Operation]:
        return [self._take]

    @override
    def getters(self) -> list[Operation]:
        return [self._show]

    @override
    def enter_initialization(self, parameters: Mapping[str, Any], horizon: Horizon = WHOLE_TIME) -> None:
        self._call("enter_initialization", dict(parameters), horizon)

    @override
    def exit_initialization(self) -> None:
        self._call("exit_initialization", show=True)
        self._show()

    @override
    def step(self, t: float, h: float) -> object:
        return self._call("step", t, h, show=True)

    @override
    def tune(self, parameter: str, value: Any) -> None:
        self._call("tune", parameter, value)

    @override
    def terminate(self) -> None:
        self._call("terminate")

    @override
    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        if self._child.is_alive:
            try:
                self._exchange("close", UnitCall("close"), _CLOSING)
            except UnitError:
                self._child.kill()
            if self._child.death(_CLOSING) is None:
                self._child.kill()
        self._child.close()
        self._folder.cleanup()


class _IsolatedEvents(EventCapability):
    """Event Mode of the FMU in the other process, by calls of its methods there."""

    def __init__(self, call: Callable[..., Any]) -> None:
        self._call = call

    @override
    def use(self, h: float, *, settles: bool = False) -> None:
        self._call("use_events", h, settles)

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


class _IsolatedState(StateCapability):
    """The state of the FMU in the other process, which keeps all that is saved."""

    def __init__(self, call: Callable[..., Any]) -> None:
        self._call = call

    @override
    def save(self) -> Any:
        return self._call("save")

    @override
    def restore(self, state: Any) -> None:
        self._call("restore", state)

    @override
    def forget(self, state: Any) -> None:
        self._call("forget", state)


def _in_words(death: Death | None) -> str:
    if death is None:
        return "it closed the pipe"
    return death.signal.name if death.signal else f"exit code {death.code}"
