"""The master: steps the units of a system at fixed communication points and keeps every row.

The row at t_k holds all outputs at the instant t_k; time is always ``start + tick * h``. The schedule is lowered once
into flat tables: one column of memory per type that all units write to and read from, and a list of prepared calls.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from components.interfaces.arguments import checked_arguments
from fmus.toolchain.stepper_library import stepper_library
from fmus.units.unit import EndRequested, ExperimentSetup, UnitError
from orchestrator.stepping.lifetime import Lifetime
from orchestrator.stepping.lowering import CompiledSchedule
from orchestrator.stepping.native_stepper import native_stepper
from orchestrator.stepping.observation import observed
from orchestrator.stepping.python_stepper import PythonStepper
from orchestrator.stepping.rows import RowLog
from orchestrator.stepping.run_status import RunStatus
from orchestrator.stepping.running_units import RunningUnits, end_remark
from orchestrator.stepping.schedule import Schedule, schedule
from orchestrator.stepping.signal_table import SignalTable
from orchestrator.stepping.simulation_error import SimulationError
from orchestrator.stepping.snapshot import Snapshot
from orchestrator.stepping.state_keeper import StateKeeper
from orchestrator.stepping.table_inputs import TableInputs
from orchestrator.stepping.writing import Writer, known_path
from orchestrator.stepping.written_inputs import WrittenInputs
from orchestrator.system.experiment import EVERYTHING, Algorithm, Choice, Tick, TimeGrid, algorithm_named
from orchestrator.system.other_values import with_values
from orchestrator.system.system import System

if TYPE_CHECKING:  # slow to import, and a run has no need of it
    import pandas as pd


class Simulation:
    """One run of a system, stepped by hand or by iteration.

    A `with` statement opens the units and closes them. Without one, as in a notebook, the first step, `read` or `write`
    opens them; they are closed at the stop time, by `close`, or with the simulation itself. Each `step` completes the
    next instant t_k: afterwards `read` sees every output at t_k, as in the row. A `write` acts until it is released.

    Args:
        system: The system.
        h: The macro step [s].
        until: The stop time [s], a whole number of macro steps after the start time.
        start: The start time [s].
        tolerance: The relative tolerance that all FMUs are told; each its own where not given.
        record: Which signals are kept at every how many ticks, by pattern; all at every tick if not given.
        algorithm: How the units exchange data: `sequential` (no hidden delay), `jacobi` or `clocked`.
        solve_loops: Whether algebraic loops are solved by iteration instead of being refused.
        native: Whether C carries out the macro steps where it can; the numbers are the same.

    Raises:
        RequestError: The system cannot be run like this: an algebraic loop, an unknown algorithm, a wrong time.
        SimulationError: When the units are opened, one of them cannot be initialised.
    """

    @checked_arguments
    def __init__(  # noqa: PLR0913 - what makes an experiment
        self,
        system: System,
        *,
        h: float,
        until: float,
        start: float = 0.0,
        tolerance: float | None = None,
        record: Choice = EVERYTHING,
        algorithm: str = Algorithm.SEQUENTIAL,
        solve_loops: bool = False,
        native: bool = True,
    ) -> None:
        self.system = self._given = system = observed(system, record)
        grid = TimeGrid(h, until, start)
        self.h, self.start, self.last_tick = h, start, grid.last_tick
        self.algorithm = algorithm_named(algorithm)
        self.schedule: Schedule = schedule(system, self.algorithm, solve_loops=solve_loops)
        self._table = SignalTable(system)
        self.log = RowLog(self._table, grid, record)
        self._from_table = TableInputs(self._table, self.log.times)
        self._written = WrittenInputs(system)
        self._running = RunningUnits(system, self.schedule, self._table, h, ExperimentSetup(start, until, tolerance))
        self._status = RunStatus(grid, self.log, self._running.by_name)
        self._writer = Writer(system, self._table, self._running.by_name)
        self._native = native
        self._keeper = StateKeeper(system, self.schedule, self._table, self.log, self._status, self._running)
        self._parameters: Mapping[str, Any] = {}
        self._replayed = ""
        times = {"h": h, "until": until, "start": start, "tolerance": tolerance}
        choices = {"record": record, "algorithm": algorithm, "solve_loops": solve_loops, "native": native}
        self._again = partial(Simulation, system, **times, **choices)
        self._lifetime = Lifetime(self, self._running.close)

    def __enter__(self) -> Self:
        self._lifetime.ends_itself = False
        return self.open()

    def open(self) -> Self:
        """Open and initialise all units, unless they are open. Raises `RequestError` and `SimulationError`."""
        self._lifetime.open(self._start, lambda: self.time)
        return self

    @checked_arguments
    def reset(self, parameters: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Go back to the start with other parameter values, such as `{"plant.m": 1700.0}`; the others are as at first.

        No unit is opened again. Raises `RequestError`, and `SimulationError`, which closes all.
        """
        self._lifetime.check(lambda: self.time)
        self.system = system = with_values(self._given, parameters)
        self._parameters = dict(parameters)
        self._status.begin_anew()
        self._keeper.begin_anew()
        self._table.begin_anew()
        self.log.begin_anew()
        self._remember(system)
        self._running.begin_anew(system)
        self._lifetime.begin_again(self, self._start)

    def save(self) -> Snapshot:
        """The state at the present tick, for `restore` and `fork`, and for a file.

        Raises:
            SimulationError: A unit cannot save its state, or cannot be opened.
        """
        self.open()
        self._status.check_complete()
        with self._told():
            return self._keeper.save(self._parameters, self._written.changes)

    @checked_arguments
    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot, or on to one: what follows is bit by bit what it would have been.

        Rows of later ticks go. Where a unit saves no state, all runs again from the start to the snapshot's tick.

        Raises:
            RequestError: It is a snapshot of another system, or the units cannot go back.
            SimulationError: A unit fails.
        """
        self.open()
        held = self._table.held
        with self._told():
            gone_back = self._keeper.restore(snapshot)
            if gone_back and snapshot.held != held:
                self._bind()
                self._compile()
        if not gone_back:
            self._replay(snapshot)
            return
        if snapshot.parameters is not self._parameters:
            self._parameters, self.system = snapshot.parameters, with_values(self._given, snapshot.parameters)
            self._remember(self.system)
        self._written.go_to(snapshot.changes)

    def _remember(self, system: System) -> None:
        self._written, self._writer = WrittenInputs(system), Writer(system, self._table, self._running.by_name)

    def _replay(self, snapshot: Snapshot) -> None:
        """Run from the start to a snapshot's tick, with all that was written on the way."""
        self.reset(snapshot.parameters)
        self.open()
        for change in snapshot.changes:
            self._advance(change.tick - 1)
            self.release(change.path) if change.value is None else self.write(change.path, change.value)
        self._advance(snapshot.tick)
        self._keeper.check_replay(snapshot)
        names = ", ".join(f"`{name}`" for name in snapshot.without_state or self._running.by_name)
        self._replayed = f"it went back to {snapshot.time:g} s by running again from the start: {names} saves no state"

    def fork(self) -> Simulation:
        """Begin another simulation of the same system from the present state; both go their own ways from here.

        Returns:
            A simulation whose first row is that of the present tick; close it, or use it in a `with` statement.

        Raises:
            RequestError: A unit can neither go to another instance nor run again from the start.
            SimulationError: A unit fails.
        """
        other = self._again()
        try:
            other.restore(self.save())
        except BaseException:
            other.close()
            raise
        return other

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def tick(self) -> int:
        """The last instant that is complete; -1 before the first step."""
        return self._status.tick

    @property
    def time(self) -> float:
        """The present instant [s]; the start time before the first step."""
        return self._status.time

    @property
    def ended(self) -> EndRequested | None:
        """What ended the run before its stop time without a fault: a unit that asked for it."""
        return self._status.ended

    @property
    def step_times(self) -> NDArray[np.float64]:
        """[s] Wall time of each macro step, (ticks,)."""
        return self._status.step_times

    def _start(self) -> None:
        with self._told():
            self._running.open()
            self._bind()
            self._running.initialise(self._status.checked, self._status.end)
            self._compile()

    def _bind(self) -> None:
        self._from_table.prepare(max(self.tick, 0))
        self._running.bind()

    def _compile(self) -> None:
        """Prepare every call of the macro step."""
        compiled = CompiledSchedule(self.system, self.schedule, self._running.by_name, self._table, self.start)
        native = native_stepper(self._status, compiled, self._from_table) if self._native else None
        self._stepper = native or PythonStepper(self._status, compiled, self._from_table)

    @contextmanager
    def _told(self) -> Generator[None]:
        """Tell of a unit that fails in the block as of one that fails in a step. Raises `SimulationError`."""
        try:
            yield
        except UnitError as fault:
            self._status.under_way = False
            raise self._fault(fault.unit, fault.reason) from fault

    def _fault(self, unit: str, reason: str) -> SimulationError:
        """The error of a unit that has failed; it is not terminated."""
        self._running.failed = unit
        return SimulationError(max(self.tick, 0), self.time, unit, reason)

    def step(self) -> Tick:
        """Complete the next instant and keep its row.

        Returns:
            The instant that was completed; the first is tick 0 at the start time.

        Raises:
            SimulationError: A unit failed, or a value is not finite.
            StopIteration: The stop time was reached before, or a unit has asked for the end.
        """
        if self.is_over:
            raise StopIteration
        self._advance(self.tick + 1)
        return Tick(self.tick, self.time)

    def _advance(self, last: int) -> None:
        """Complete the ticks up to `last`, or to where a unit asks for the end. Raises `SimulationError`."""
        if not self._lifetime.is_open:
            self.open()
        self._status.check_complete()
        with self._told():
            self._stepper.advance(last)
        if self._lifetime.ends_itself and self.is_over:
            self._lifetime.end()

    def __iter__(self) -> Iterator[Tick]:
        while not self.is_over:
            yield self.step()

    @property
    def is_over(self) -> bool:
        """Whether the stop time is reached, or a unit has asked for the end."""
        return self._status.is_over

    def run(self) -> None:
        """Step to the stop time, or to where a unit asks for the end. Raises `SimulationError` as `step` does."""
        if not self.is_over:
            self._advance(self.last_tick)

    @property
    def remarks(self) -> list[str]:
        """What a person should know of how the run went: the end that a unit asked for, and the units' remarks."""
        ends = [] if self.ended is None else [end_remark(self.ended, self.time)]
        replayed = [self._replayed] if self._replayed else []
        return [*ends, *replayed, *self._running.remarks, *self.log.finiteness.remarks(), *self._stepper_remarks()]

    def _stepper_remarks(self) -> list[str]:
        reason = stepper_library().reason if self._native and self.tick >= 0 else ""
        return [f"stepped by Python, which is slower: {reason}"] if reason else []

    @checked_arguments
    def read(self, path: str) -> Any:
        """Read the present value of an output. Raises `RequestError` where there is no such output.

        Args:
            path: The signal with its unit, such as `plant.state.v_x`.

        Returns:
            A number, or an array of the signal's shape `(n,)`, in the unit of measurement that the port declares.
        """
        path = known_path(self.system, path, "recorded")
        if self._lifetime.is_new:
            self.open()
        return self._table.read(path)

    @checked_arguments
    def write(self, path: str, value: Any) -> None:
        """Hold an input at a value from now on, in place of its connection, or change a tunable parameter.

        Args:
            path: The signal or the parameter with its unit, such as `plant.actuation.delta_f`.
            value: A number, or an array of its shape `(n,)`, in the unit of measurement that it declares.

        Raises:
            RequestError: There is no such input, the parameter is fixed, or the value is none that it can take.
            SimulationError: The unit refuses the value.
        """
        self._change(path, value, partial(self._writer.write, path, value))

    @checked_arguments
    def release(self, path: str) -> None:
        """Give a written input back to its connection, or a parameter the value that it had at the start.

        Args:
            path: The signal or the parameter with its unit, as it was written.

        Raises:
            RequestError: There is no such input, or the parameter is fixed.
            SimulationError: The unit refuses the value.
        """
        self._change(path, None, partial(self._writer.release, path))

    def _change(self, path: str, value: Any, change: Callable[[], None]) -> None:
        self.open()
        with self._told():
            change()
            self._written.note(self.tick + 1, path, value)
            self._bind()
            self._compile()

    def frame(self) -> pd.DataFrame:
        """Give all rows so far as a data frame, with the columns that `columns` describes."""
        import pandas as pd  # noqa: PLC0415

        return pd.DataFrame(self.columns())

    def columns(self) -> dict[str, NDArray[Any]]:
        """Give all rows so far as arrays.

        Returns:
            Arrays of shape `(n,)` for n rows: `time` [s], then one per signal element, then the inputs that follow
            a table, and what was written. With a choice of what is recorded there is a row for each tick at which
            something was, with NaN for the signals that were not.
        """
        return self.rows(0, self.log.kept)

    def rows(self, first: int, last: int) -> dict[str, NDArray[Any]]:
        """Give the rows of the ticks from `first` to before `last` as `columns` gives all."""
        ticks, kept = self.log.columns(first, last)
        tabled = self._from_table.received(ticks)
        return {"time": self.log.times[ticks], **kept, **tabled, **self._written.received(kept, ticks, tabled)}

    def close(self) -> None:
        """End the simulation of all units that have not failed, and release all; rows and values stay."""
        self._lifetime.close()
