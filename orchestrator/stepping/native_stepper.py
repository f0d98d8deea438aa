"""The native stepper: the lowered schedule as flat tables, which C carries out (`fmus/runtime/stepper.c`).

It gives the bits of the Python loop. What C cannot do itself (units that live elsewhere, texts, loops, events) and all
that is unusual (a status, a flag, a value that is not finite) it asks Python for, in the midst of the step.
"""
# pyright: basic
# ctypes carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

from fmus.toolchain.stepper_library import stepper_library
from fmus.units.prepared_calls import AccessCall, CallSeries, Copy, Gather, StepCall, address_of, is_direct
from fmus.units.unit import EndRequested, Operation, UnitError
from orchestrator.stepping.lowering import Call, CompiledSchedule, UnitStep
from orchestrator.stepping.native_tables import (
    ENDED,
    FAIL,
    FAILED,
    GO_ON,
    KINDS,
    NOT_FINITE,
    NativeOperation,
    NativeProgram,
    NativeWatch,
    PythonCall,
    address,
    copied,
    moved,
)
from orchestrator.stepping.row_group import RowGroup
from orchestrator.stepping.run_status import RunStatus
from orchestrator.stepping.table_inputs import TableInputs

LONGEST_PERIOD: Final = 1000
"""[ticks] The longest pattern of calls that is laid out; the steps of units with longer ones are left to Python."""
_SLICE: Final = 0.02
"""[s] After this time of stepping, signals of the operating system are dealt with, and others may read the rows."""


class MadeByC:
    """A call that C makes itself; Python looks at what it returned, where that is unusual.

    Args:
        name: The function of FMI.
        outcome: What a step comes to, as `StepCall.outcome`; None for other calls, whose status says it.
    """

    def __init__(self, name: str, outcome: Callable[[int, float, float], object] | None) -> None:
        self.__name__, self.outcome = name, outcome

    def __call__(self) -> None:
        """Nothing: it has been made."""


class NativeStepper:
    """Carries out the macro steps of a run, many in one call.

    Args:
        library: The native stepper.
        run: The run.
        compiled: The calls of every macro step.
        tables: The inputs that follow a table.
    """

    def __init__(self, library: ctypes.CDLL, run: RunStatus, compiled: CompiledSchedule, tables: TableInputs) -> None:
        self._run, self._log = run, run.log
        self._advance = library.stepper_advance
        self._advance.argtypes = [ctypes.c_size_t, ctypes.c_int64, ctypes.c_double]
        self._advance.restype = ctypes.c_int32
        self._calls: list[list[Call]] = []
        self._raised: BaseException | None = None
        self._alive: list[Any] = []
        """What keeps the arrays alive whose addresses the tables contain."""
        operations, bounds = self._lowered(compiled, tables)
        watched = [
            NativeWatch(address(w.values), address(w.expected), w.values.size, w.values.itemsize)
            for w in self._log.finiteness.watched
        ]
        self._program = NativeProgram(
            operations=self._table(NativeOperation, operations),
            bounds=self._table(ctypes.c_int32, bounds),
            watched=self._table(NativeWatch, watched),
            n_watched=len(watched),
            period=compiled.period,
            start=run.start,
            h=run.h,
            kept=address(self._log.number_kept),
            step_times=address(run.step_times),
            python=PythonCall(self._python),
        )
        self._at = ctypes.addressof(self._program)
        self._rows_in = -1

    def advance(self, last: int) -> None:
        """Complete the ticks up to `last`, or to where a unit asks for the end.

        Raises:
            SimulationError: A value is not finite, or something else ends the run.
            UnitError: A unit failed.
        """
        run, program = self._run, self._program
        while run.tick < last and not run.is_over:
            until = self._log.reserve(run.tick + 1)
            if self._log.place != self._rows_in:
                self._keep_rows()
            program.tick, program.stop = run.tick, run.ended is not None
            try:
                end = self._advance(self._at, min(last, until - 1), _SLICE)
            finally:  # Ctrl-C comes after the call, whose ticks must not get lost
                run.tick = program.tick
            if end == FAILED:
                raised, self._raised = self._raised, None
                run.under_way = not isinstance(raised, UnitError)
                raise raised or KeyboardInterrupt  # which came before Python could say anything
            run.shorten()
            run.complete(finite=end != NOT_FINITE or self._log.finiteness.holds(run.tick))

    def _python(self, number: int, status: int) -> int:
        """Carry out calls, or look at the status of one that C has made; the answer is one of `native_tables`."""
        run, answer = self._run, GO_ON
        tick, run.tick = run.tick, self._program.tick
        try:
            for function, timed, unit in self._calls[number]:
                try:
                    found = self._found(function, timed=timed, status=status)
                except EndRequested as end:
                    run.end(end)
                    self._program.stop, answer = 1, ENDED
                    continue
                if found:
                    run.checked(run.units[unit], found, function)
        except BaseException as error:  # noqa: BLE001 - also Ctrl-C must not get lost on its way through C
            self._raised = error
            return FAIL
        finally:
            run.tick = tick
        return answer

    def _found(self, function: Any, *, timed: bool, status: int) -> object:
        if isinstance(function, MadeByC):
            program = self._program
            return function.outcome(status, program.t, program.length) if function.outcome else status
        run = self._run
        return function(run.start + run.tick * run.h, run.h) if timed else function()

    def _lowered(self, compiled: CompiledSchedule, tables: TableInputs) -> tuple[list[NativeOperation], list[int]]:
        """All operations, and for each phase where those begin that lead to the next tick, and that complete it."""
        operations: list[NativeOperation] = []
        bounds: list[int] = []
        for phase in range(compiled.period):
            bounds.append(len(operations))
            operations += self._operations(compiled.after(phase))
            bounds.append(len(operations))
            operations += self._from_tables(tables)
            operations += self._operations(compiled.before((phase + 1) % compiled.period))
        return operations, [*bounds, len(operations)]

    def _from_tables(self, tables: TableInputs) -> list[NativeOperation]:
        if any(values.dtype.kind == "O" for _, _, values in tables.copies):
            return [self._asked([(lambda: tables.apply(self._run.tick), False, "")])]
        self._alive.append(tables.copies)
        return [moved("table", values, column, places=places) for column, places, values in tables.copies]

    def _operations(self, calls: Sequence[Call]) -> Iterator[NativeOperation]:
        """The operations of calls; those for Python that follow each other are one."""
        waiting: list[Call] = []
        for call in calls:
            native = self._native(call)
            if native is None:
                waiting.append(call)
            else:
                if waiting:
                    yield self._asked(waiting)
                    waiting = []
                yield from native
        if waiting:
            yield self._asked(waiting)

    def _asked(self, calls: list[Call]) -> NativeOperation:
        self._calls.append(calls)
        return NativeOperation(kind=KINDS["python"], call=len(self._calls) - 1)

    def _native(self, call: Call) -> list[NativeOperation] | None:
        """The operations that C makes of a call; None where it has to ask Python."""
        function, _, unit = call
        if isinstance(function, UnitStep):
            found = function.unit.step_call
            return None if found is None else [self._step(function, found, unit)]
        self._alive.append(function)
        parts = function.calls if isinstance(function, CallSeries) else (function,)
        operations = [self._simple(part, unit) for part in parts]
        return None if None in operations else [o for o in operations if o is not None]

    def _simple(self, function: Operation, unit: str) -> NativeOperation | None:
        match function:
            case AccessCall() if is_direct(function.func):
                return self._access(function, unit)
            case Gather() if function.source.dtype.kind != "O":
                return moved("gather", function.source, function.target, places=function.places)
            case Copy():
                return copied(function.source, function.target, function.conversion)
            case _:
                return None

    def _made_by_c(self, name: str, outcome: Any, unit: str) -> int:
        """The number of a call that C makes itself, by which it asks what a status comes to."""
        self._calls.append([(MadeByC(name, outcome), False, unit)])
        return len(self._calls) - 1

    def _access(self, call: AccessCall, unit: str) -> NativeOperation:
        component, references, n_references, values, *n_values = call.args
        return NativeOperation(
            kind=KINDS["access_fmi3" if n_values else "access_fmi2"],
            call=self._made_by_c(call.func.__name__, None, unit),
            function=address_of(call.func),
            component=component,
            places=references,
            first=n_references,
            target=values,
            count=n_values[0] if n_values else 0,
        )

    def _step(self, step: UnitStep, call: StepCall, unit: str) -> NativeOperation:
        return NativeOperation(
            kind=KINDS["step_fmi3" if call.results else "step_fmi2"],
            call=self._made_by_c("", call.outcome, unit),
            earlier=step.earlier,
            multiple=step.multiple,
            parts=step.parts,
            function=call.function,
            component=call.component,
            results=(ctypes.c_size_t * 4)(*call.results),
        )

    def _keep_rows(self) -> None:
        """Keep rows in the present block of memory."""
        rows = [operation for group in self._log.groups for operation in self._kept(group)]
        self._row_table = (NativeOperation * len(rows))(*rows)
        self._program.rows, self._program.n_rows = ctypes.addressof(self._row_table), len(rows)
        self._rows_in = self._log.place  # at last: Ctrl-C may come before

    def _kept(self, group: RowGroup) -> Iterator[NativeOperation]:
        copies = [*((values, rows, None) for rows, values in group.copies), *((v, r, p) for r, v, p in group.picks)]
        if any(values.dtype.kind == "O" for values, _, _ in copies):
            yield self._asked([(lambda: group.keep(self._run.tick), False, "")])
            return
        for values, rows, places in copies:
            operation = moved("row", values, rows, places=places)
            operation.first, operation.multiple = group.begin, group.every
            yield operation

    def _table(self, kind: Any, items: Sequence[Any]) -> int:
        table = (kind * len(items))(*items)
        self._alive.append(table)
        return ctypes.addressof(table)


def native_stepper(run: RunStatus, compiled: CompiledSchedule, tables: TableInputs) -> NativeStepper | None:
    """The native stepper for a run; None where there is none, or the pattern of the calls is too long for it."""
    library = stepper_library().library
    if library is None or compiled.period > LONGEST_PERIOD:
        return None
    return NativeStepper(library, run, compiled, tables)
