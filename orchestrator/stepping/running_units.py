"""The running units of a simulation, from their opening to their release."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from fmus.toolchain.last_call import name_of
from fmus.units.unit import DEFAULT_SETUP, EndRequested, ExperimentSetup, NoResetError, Unit, UnitError
from orchestrator.stepping.initialization import initialise
from orchestrator.stepping.lowering import events_of
from orchestrator.stepping.schedule import Schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.stepping.snapshot import StateStore
from orchestrator.system.opening import opening
from orchestrator.system.system import System

StatusCheck: TypeAlias = Callable[[Unit, object], None]
"""Raises an error for the status of a unit's call."""


class RunningUnits:
    """All units of a system; the methods raise `UnitError`.

    Args:
        system: The whole system.
        schedule: Its schedule.
        table: The signal table that the units are bound to.
        h: The macro step [s].
        setup: The experiment.
    """

    def __init__(
        self, system: System, schedule: Schedule, table: SignalTable, h: float, setup: ExperimentSetup = DEFAULT_SETUP
    ) -> None:
        self._system, self._schedule, self._table, self._h, self._setup = system, schedule, table, h, setup
        self.by_name: dict[str, Unit] = {}
        """The units that have been opened, in the order of the system."""
        self.states = StateStore()
        """The states that were saved inside the units; they go when a unit is closed."""
        self.failed: str | None = None
        """The unit that has failed, which is not terminated."""
        self._initialised: set[str] = set()
        self._of_opening: dict[str, tuple[str, ...]] = {}
        """The remarks on units that were opened; those that follow are about a run."""

    def begin_anew(self, system: System) -> None:
        """Have the parameter values of a system, which is the same otherwise, from the next call of `open` on."""
        self._system = system
        if not self._of_opening:
            self.by_name.clear()  # closed units, which would still tell what they had to say

    def open(self) -> None:
        """Open all units, with Event Mode where the schedule uses it or a unit demands it; reset those that are open.

        Raises:
            RequestError: A unit cannot be opened.
        """
        if self._of_opening:
            self._reset()
            return
        with opening(self._system.units.values()):
            for name in self._system.units:
                self._open(name)
        for name in self.by_name:
            self._use_events(name)

    def _open(self, name: str) -> None:
        self.by_name[name] = unit = self._system.units[name].open(name)
        self._of_opening[name] = tuple(unit.remarks)

    def _reset(self) -> None:
        """Reset all units. One that has failed, or cannot be reset, is closed, and opened again in its place."""
        for name, unit in self.by_name.items():
            try:
                if name == self.failed:
                    raise NoResetError(name, "it has failed", ())
                if name in self._initialised:
                    unit.terminate()
                unit.reset()
                unit.remarks[:] = self._of_opening[name]
            except UnitError:
                self.states.release()
                self._initialised.discard(name)
                unit.close()
                self._open(name)
                self._use_events(name)
        self.failed = None
        self._initialised.clear()

    def _use_events(self, name: str) -> None:
        unit = self.by_name[name]
        h = self._h * float(self._system.steps.get(name, 1))
        if name in self._schedule.events:
            events_of(unit).use(h, settles=name not in self._schedule.early)
        elif unit.events is not None and unit.events.demanded:
            unit.events.use(h, settles=True)

    def bind(self) -> None:
        """Bind all units to the table, as it is."""
        for unit in self.by_name.values():
            self._table.bind(unit)

    def initialise(self, checked: StatusCheck, end: Callable[[EndRequested], None]) -> None:
        """Lead all units, which are bound, through the initialisation.

        Args:
            checked: Raises an error for the status of a unit's call.
            end: Called for a unit that asks for the end of the run already.
        """
        for name, source in self._system.units.items():
            self.by_name[name].enter_initialization(source.parameters, self._setup)
        initialise(self._system, self._schedule, self.by_name, self._table, checked)
        for name, unit in self.by_name.items():
            try:
                unit.exit_initialization()
            except EndRequested as ended:
                end(ended)
            self._initialised.add(name)
            for function in unit.getters():  # events at the start may have changed what is shown
                checked(unit, function())

    @property
    def remarks(self) -> list[str]:
        """What a person should know of how the units were run; what several have to say stands there once."""
        told: dict[str, list[str]] = {}
        for name, unit in self.by_name.items():
            for remark in unit.remarks:
                told.setdefault(remark, []).append(f"`{name}`")
        return [f"unit{'s' if names[1:] else ''} {', '.join(names)}: {remark}" for remark, names in told.items()]

    def close(self) -> None:
        """Terminate all units that have not failed, and release all."""
        self.states.release()
        for name, unit in self.by_name.items():
            if name in self._initialised and name != self.failed:
                try:
                    unit.terminate()
                    unit.tell_messages()
                except UnitError as error:
                    unit.remarks.append(error.reason)
            self._initialised.discard(name)
            unit.close()
        self._of_opening.clear()


def end_remark(ended: EndRequested, time: float) -> str:
    """What a person should know of the end that a unit asked for, in a run whose last row is at `time` [s]."""
    shown = f", at {time:g} s, has its values of then" if ended.time < time else " has its values"
    return f"{ended}: the run ends there, and its last row{shown}"


def failure_reason(unit: Unit, status: int, function: object = None) -> str:
    """What a unit did that returned the FMI status of a failure, and what it said about it."""
    words = {
        2: "discarded the step",
        3: "returned an error",
        4: "returned a fatal error",
        5: "returned `pending`, which nobody asked for",
    }
    said = "; ".join(unit.messages.said())
    what = words.get(status, f"returned the status {status}, which FMI does not have")
    name = name_of(function) or unit.called()
    return (f"`{name}` " if name else "") + what + (f": {said}" if said else "")
