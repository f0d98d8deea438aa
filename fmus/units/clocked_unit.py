"""An FMI 3.0 Co-Simulation FMU that can be run with Event Mode."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

from typing_extensions import override

from fmus.reading.archive import Archive
from fmus.toolchain.fmpy_library import FMICallException
from fmus.units.capabilities import EventCapability, StateCapability
from fmus.units.co_simulation import Fmu3Unit
from fmus.units.event_mode import EventError, EventMode, StepResult
from fmus.units.fmu_unit import NONSENSE, in_words
from fmus.units.prepared_calls import StepCall
from fmus.units.state_bytes import joined, parted
from fmus.units.unit import Operation, TypedColumns, Unit, UnitError


class ClockedUnit(Fmu3Unit):
    """As `Fmu3Unit`, until its events are used."""

    def __init__(self, name: str, archive: Archive) -> None:
        self._event_mode_used = False
        super().__init__(name, archive)
        self.events = self._events = ClockedEvents(self, self._fmu, self._use_event_mode)
        self._events.demanded = self._event_mode_used
        if self.state is not None:
            self.state = _ClockedState(self.state, self._events)

    @override
    def _make_quiet_instance(self) -> None:
        """Make an instance without Event Mode, or with it where the FMU demands it."""
        try:
            super()._make_quiet_instance()
        except Exception:  # noqa: BLE001 - FMPy raises bare Exception
            self._event_mode_used = True
            try:
                super()._make_quiet_instance()
            except Exception:
                self._event_mode_used = False
                raise
            self.messages.clear()
            self.remarks.append("it runs with Event Mode only, which it is given")

    @override
    def _instantiate(self, *, logging: bool) -> None:
        events = self._event_mode_used
        self._fmu.instantiate(
            loggingOn=logging, eventModeUsed=events, earlyReturnAllowed=events, logMessage=self._logged
        )

    def _use_event_mode(self) -> None:
        """Replace an instance without Event Mode by one with it."""
        if self._event_mode_used:
            return
        self._free_instance()
        self._event_mode_used = True
        try:
            super()._make_quiet_instance()
        except Exception as error:  # FMPy raises bare Exception
            raise UnitError(self.name, f"could not be instantiated with Event Mode ({error})", self.messages) from error
        self._take_address()

    @override
    def bind(self, inputs: TypedColumns, outputs: TypedColumns, unset: Collection[str] = ()) -> None:
        super().bind(inputs, outputs, unset)
        mode = self._events.mode
        if mode is None:
            return
        if self._archive.clocks_of:
            moves = self._each("Set", inputs)
            moves = {name: move for name, move in moves.items() if name not in unset}
            self._setters = list(self._by_clock(moves, mode))
            self._getters = list(self._by_clock(self._each("Get", outputs), mode))
        if self._events.demanded and mode.settles and self._setters:
            self._setters = [self._events.open, *self._setters, self._events.settle]

    def _by_clock(self, moves: Mapping[str, Operation], mode: EventMode) -> Iterable[Operation]:
        """The calls; that of a clocked variable does nothing while none of its clocks ticks."""
        for name, move in moves.items():
            clocks = self._archive.clocks_of.get(name)
            yield move if clocks is None else _while_active(move, clocks, mode)

    @override
    def tune(self, parameter: str, value: Any) -> None:
        mode = self._events.mode
        if mode is None:
            super().tune(parameter, value)
            return
        self._events.check("Event Mode failed", mode.interrupt)
        super().tune(parameter, value)
        self._events.check("the discrete states could not be updated", mode.update, mode.now)

    @override
    def exit_initialization(self) -> None:
        mode = self._events.mode
        if mode is None:
            super().exit_initialization()
            return
        self._events.check("the clocks could not be set", mode.prepare)
        super().exit_initialization()
        self._events.check("the clocks could not be read", mode.begin, self._setup.start)

    @override
    def reset(self) -> None:
        super().reset()
        self._events.begin_anew()

    @override
    def step(self, t: float, h: float) -> object:
        mode = self._events.mode
        if mode is None:
            return super().step(t, h)
        return self._events.check("the step failed", mode.step, self._advance, t, h)

    @property
    @override
    def step_call(self) -> StepCall | None:
        return super().step_call if self._events.mode is None else None

    def _advance(self, t: float, h: float) -> StepResult:
        status = self._do_step(self._component, t, h, 1, *self._results)
        event, terminate, early = (bool(flag) for flag in self._flags.raw)
        interrupted = event or early
        return StepResult(int(status), interrupted, terminate, self._reached.value if interrupted else t + h)


class ClockedEvents(EventCapability):
    """Event Mode of a `ClockedUnit`.

    Args:
        unit: The unit, for its messages and its clocks.
        fmu: The FMU as an object of FMPy.
        use_event_mode: Sees to it that the instance has Event Mode.
    """

    def __init__(self, unit: Unit, fmu: Any, use_event_mode: Callable[[], None]) -> None:
        self._unit, self._fmu, self._use_event_mode = unit, fmu, use_event_mode
        self.mode: EventMode | None = None
        """The events of the present run, once they are used."""
        self._new_mode: Callable[[], EventMode | None] = lambda: None

    def check(self, action: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function; `action` names the failure in the error. Raises `UnitError`."""
        try:
            return function(*arguments)
        except EventError as error:
            raise UnitError(self._unit.name, f"{action}: {error}", self._unit.messages) from error
        except (FMICallException, *NONSENSE) as error:
            raise UnitError(self._unit.name, f"{action}: {in_words(error)}", self._unit.messages) from error

    @property
    def _used(self) -> EventMode:
        assert self.mode is not None  # noqa: S101 - the schedule asks only units that use Event Mode
        return self.mode

    @override
    def use(self, h: float, *, settles: bool = False) -> None:
        self._use_event_mode()
        name, clocks = self._unit.name, self._unit.interface.clocks
        self._new_mode = lambda: EventMode(name, self._fmu, clocks, h, settles=settles)
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget the events of a run; the unit has to be bound again."""
        self.mode = self._new_mode()

    def open(self) -> object:
        """Enter Event Mode at the present time, where the schedule does not do it."""
        return 0 if not self._used.running else self.check("Event Mode failed", self._used.activate, self._used.now)

    def settle(self) -> object:
        """End what `open` began."""
        return 0 if not self._used.running else self.update(self._used.now, 0.0)

    @override
    def activate(self, t: float, h: float) -> object:
        return self.check("Event Mode failed", self._used.activate, t)

    @override
    def update(self, t: float, h: float) -> object:
        return self.check("the discrete states could not be updated", self._used.update, t)

    @override
    def fired(self) -> set[str]:
        return self._used.take_fired()

    @override
    def trigger(self, clock: str) -> None:
        self._used.trigger(clock)


class _ClockedState(StateCapability):
    """The state of the FMU, with that of its clocks where its events are used."""

    def __init__(self, inner: StateCapability, events: ClockedEvents) -> None:
        self._inner, self._events = inner, events
        self.serializes = inner.serializes

    @override
    def save(self) -> Any:
        mode = self._events.mode
        return self._inner.save(), None if mode is None else mode.saved()

    @override
    def restore(self, state: Any) -> None:
        inner, clocks = state
        self._inner.restore(inner)
        if self._events.mode is not None:
            self._events.mode.restore(clocks)

    @override
    def forget(self, state: Any) -> None:
        self._inner.forget(state[0])

    @override
    def serialized(self, state: Any) -> bytes:
        return joined([self._inner.serialized(state[0]), json.dumps(state[1]).encode()])

    @override
    def deserialized(self, content: bytes) -> Any:
        inner, clocks = parted(content, 2)
        return self._inner.deserialized(inner), json.loads(clocks)


def _while_active(move: Operation, clocks: frozenset[int], mode: EventMode) -> Operation:
    return lambda: move() if clocks & mode.active else 0
