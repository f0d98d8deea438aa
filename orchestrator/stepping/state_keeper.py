"""Saving and restoring a simulation: the states of its units, and all that the master itself remembers."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from components.interfaces.problem import refuse
from fmus.toolchain.file_digest import digest_of
from orchestrator.stepping.rows import RowLog
from orchestrator.stepping.run_status import RunStatus
from orchestrator.stepping.running_units import RunningUnits
from orchestrator.stepping.schedule import Schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.stepping.snapshot import SavedStates, Snapshot
from orchestrator.stepping.written_inputs import WrittenValue
from orchestrator.system.system import System


class StateKeeper:
    """Makes snapshots of a run and goes back to them.

    Args:
        system: The whole system.
        schedule: Its schedule.
        table: The signal table.
        log: The rows.
        status: How far the run has come.
        running: The running units.
    """

    def __init__(  # noqa: PLR0913 - what makes up the state
        self,
        system: System,
        schedule: Schedule,
        table: SignalTable,
        log: RowLog,
        status: RunStatus,
        running: RunningUnits,
    ) -> None:
        self._system, self._schedule = system, schedule
        self._table, self._log, self._status, self._running = table, log, status, running
        self._digest = ""

    def save(self, parameters: Mapping[str, Any], changes: tuple[WrittenValue, ...]) -> Snapshot:
        """The present state; `parameters` and `changes` are what the program has set. Raises `UnitError`."""
        units = self._running.by_name
        without = tuple(name for name, unit in units.items() if unit.state is None)
        saved = None
        if not without:
            saved = SavedStates({n: (unit.state, unit.state.save()) for n, unit in units.items() if unit.state})
            self._running.saved.add(saved)
        return Snapshot(
            tick=self._status.tick,
            time=self._status.time,
            columns={kind: column.copy() for kind, column in self._table.columns.items()},
            held=self._table.held,
            changes=changes,
            parameters=parameters,
            ended=self._status.ended,
            without_state=without,
            digest=self.digest,
            saved=saved,
        )

    def restore(self, snapshot: Snapshot) -> bool:
        """Go back to a snapshot of this system; return whether that was possible without a replay.

        Raises:
            RequestError: It is one of another system.
            UnitError: A unit cannot restore its state.
        """
        saved = snapshot.saved
        mine = saved is not None and saved.are_there and saved in self._running.saved
        if not mine:
            snapshot.check(self.digest(), self._table.columns)
        if saved is not None and mine:
            for capability, state in saved.states.values():
                capability.restore(state)
        elif not self._read(snapshot):
            return False
        for kind, column in self._table.columns.items():
            column[:] = snapshot.columns[kind]
        self._table.held = snapshot.held
        self._status.tick, self._status.ended = snapshot.tick, snapshot.ended
        self._log.go_to(snapshot.tick)
        return True

    def _read(self, snapshot: Snapshot) -> bool:
        """Restore states that come from elsewhere, as bytes; return whether all units can do that."""
        units, content = self._running.by_name, snapshot.states()
        if not all(unit.state is not None and unit.state.serializes and n in content for n, unit in units.items()):
            return False
        for name, unit in units.items():
            if unit.state is not None:
                try:
                    state = unit.state.deserialized(content[name])
                except ValueError as error:
                    raise refuse(
                        "snapshot", f"a damaged state of `{name}` ({error})", "one that was written"
                    ) from error
                unit.state.restore(state)
                unit.state.forget(state)
        return True

    def check_replay(self, snapshot: Snapshot) -> None:
        """Refuse a replay that did not lead to the values of the snapshot, by the unit that showed others first.

        Raises:
            RequestError: It did not.
        """
        for element in self._table.elements():
            now, then = (columns[element.type][element.position] for columns in (self._table.columns, snapshot.columns))
            if now != then and not (element.type.is_float and np.isnan(now) and np.isnan(then)):
                found = f"{now} in place of {then} after a replay from the start"
                valid = "a unit that saves its state, or shows the same values in each run"
                raise refuse(element.path, found, valid, f"`{element.unit}` cannot go back.")

    def digest(self) -> str:
        """What tells this system apart from others: its units, FMUs, connections, step and algorithm."""
        if not self._digest:
            facts = json.dumps([self._facts(), str(self._schedule), self._status.h, self._status.start])
            self._digest = hashlib.sha256(facts.encode()).hexdigest()
        return self._digest

    def _facts(self) -> list[Any]:
        units: list[Any] = []
        for name, source in self._system.units.items():
            about, interface = source.describe(), source.interface
            variables = [(v.name, v.quantity.type.value, v.size) for v in (*interface.inputs, *interface.recorded)]
            file = None if about.file is None else digest_of(about.file)
            step = str(self._system.steps.get(name, 1))
            units.append([name, about.kind, about.runs_as, file, step, variables, source.mapping_text()])
        return [units, [f"{wire} {wire.conversion}" for wire in self._system.connections]]
