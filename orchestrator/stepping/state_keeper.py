"""Saving and restoring a simulation: the states of its units, and all that the master itself remembers."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from components.interfaces.problem import Problem, RequestError, raise_if_any, refuse
from fmus.toolchain.file_digest import digest_of
from fmus.units.unit import UnitError
from orchestrator.stepping.rows import RowLog
from orchestrator.stepping.run_status import RunStatus
from orchestrator.stepping.running_units import RunningUnits
from orchestrator.stepping.schedule import Schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.stepping.snapshot import Past, Snapshot, UnitStates
from orchestrator.stepping.writing import written_variable
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
        self._past: Past = ()
        self.begin_anew()

    def begin_anew(self) -> None:
        """Begin other rows, at the start."""
        self._past = ((0, object()),)

    def save(self, parameters: Mapping[str, Any], changes: tuple[WrittenValue, ...]) -> Snapshot:
        """The present state; `parameters` and `changes` are what the program has set. Raises `UnitError`."""
        states = {name: unit.state for name, unit in self._running.by_name.items()}
        without = tuple(name for name, state in states.items() if state is None)
        able = {name: state for name, state in states.items() if state is not None}
        return Snapshot(
            tick=self._status.tick,
            time=self._status.time,
            columns={kind: column.copy() for kind, column in self._table.columns.items()},
            held=self._table.held,
            changes=changes,
            parameters=parameters,
            ended=self._status.ended,
            without_state=without,
            digest=self.digest(),
            past=self._until(self._status.tick),
            saved=None if without else self._running.states.save(able),
        )

    def restore(self, snapshot: Snapshot) -> bool:
        """Go back to a snapshot of this system; return whether that was possible without a replay.

        Raises:
            RequestError: It is one of another system, of a later tick than the last one, or damaged.
            UnitError: A unit cannot restore its state.
        """
        if snapshot.saved is not None and snapshot.saved.store is self._running.states and snapshot.inside:
            for capability, state in snapshot.inside.values():
                capability.restore(state)
        else:
            self.check(snapshot)
            if not self._read(snapshot):
                return False
        for kind, column in self._table.columns.items():
            column[:] = snapshot.columns[kind]
        self._table.held = snapshot.held
        self._running.failed = None
        self._status.go_to(snapshot.tick, snapshot.ended)
        self._log.go_to(snapshot.tick, same_past=self._until(snapshot.tick) == snapshot.past)
        self._past = (*snapshot.past, (snapshot.tick + 1, object()))
        if snapshot.tick >= 0 and snapshot.time < self._status.time:
            self._log.shorten(snapshot.tick, snapshot.time)
        return True

    def _until(self, tick: int) -> Past:
        """The parts of the past up to a tick; those that begin later say nothing of it."""
        return tuple(part for part in self._past if part[0] <= tick)

    def check(self, snapshot: Snapshot) -> None:
        """Refuse a snapshot that this simulation cannot have made. Raises `RequestError`."""
        shapes = {kind: column.shape for kind, column in self._table.columns.items()}
        if snapshot.digest != self.digest() or {k: c.shape for k, c in snapshot.columns.items()} != shapes:
            valid = "one of the same system: units, FMUs, connections, step and algorithm"
            raise refuse("snapshot", "one of another system", valid, "Make one with `save`.")
        if not -1 <= snapshot.tick <= self._status.last_tick:
            found = f"one of the tick {snapshot.tick}, at {snapshot.time:g} s"
            raise refuse("snapshot", found, f"one of a tick up to {self._status.last_tick}", "Set a later stop time.")
        inputs = {(name, v.name) for name, source in self._system.units.items() for v in source.interface.inputs}
        raise_if_any(self._damages(snapshot, inputs))

    def _damages(self, snapshot: Snapshot, inputs: Collection[tuple[str, str]]) -> Iterator[Problem]:
        """What cannot be in a snapshot that somebody has not changed."""
        valid = "what `Snapshot.write` has written"
        if not (snapshot.held <= set(inputs)):
            yield Problem("snapshot: held", "inputs that there are not", valid)
        for change in snapshot.changes:
            where = f"snapshot: {change.path}"
            try:
                variable = written_variable(self._system, change.path)
            except RequestError:
                yield Problem(where, "no input or tunable parameter", valid)
                continue
            if change.value is not None and variable.quantity.problems(change.path, change.value):
                yield Problem(where, "a value that it cannot take", valid)
            if not 0 <= change.tick <= snapshot.tick + 1:
                yield Problem(where, f"the tick {change.tick}", valid)

    def _read(self, snapshot: Snapshot) -> bool:
        """Restore states that come from elsewhere, as bytes; return whether all units can do that."""
        units, content = self._running.by_name, snapshot.states()
        if not all(unit.state is not None and unit.state.serializes and n in content for n, unit in units.items()):
            return False
        states: UnitStates = {}
        try:
            for name, unit in units.items():
                if unit.state is not None:
                    states[name] = unit.state, unit.state.deserialized(content[name])
            for capability, state in states.values():
                capability.restore(state)
        except (ValueError, TypeError) as error:
            name = next(name for name in units if name not in states)
            found = f"a damaged state of `{name}` ({error})"
            raise refuse("snapshot", found, "one that was written") from error
        finally:
            for capability, state in states.values():
                with suppress(UnitError):
                    capability.forget(state)
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
