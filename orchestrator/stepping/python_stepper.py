"""The stepper in Python: what happens in a macro step, to be read, and the reference of the native one."""

from __future__ import annotations

import time

from fmus.units.unit import EndRequested
from orchestrator.stepping.lowering import Call, CompiledSchedule
from orchestrator.stepping.run_status import RunStatus
from orchestrator.stepping.table_inputs import TableInputs


class PythonStepper:
    """Carries out the macro steps of a run, call by call.

    Args:
        run: The run.
        compiled: The calls of every macro step.
        tables: The inputs that follow a table.
    """

    def __init__(self, run: RunStatus, compiled: CompiledSchedule, tables: TableInputs) -> None:
        self._run, self._compiled, self._tables = run, compiled, tables

    def advance(self, last: int) -> None:
        """Complete the ticks up to `last`, or to where a unit asks for the end.

        Raises:
            SimulationError: A value is not finite, or something else ends the run.
            UnitError: A unit failed.
        """
        while self._run.tick < last and not self._run.is_over:
            self._complete_next()

    def _complete_next(self) -> None:
        run = self._run
        began = time.perf_counter()
        run.under_way = True
        if run.tick >= 0:
            self._carry_out(self._compiled.after(run.tick))
        run.tick += 1
        self._tables.apply(run.tick)
        self._carry_out(self._compiled.before(run.tick))
        run.shorten()
        finite = run.log.keep(run.tick)
        run.under_way = False
        run.step_times[run.tick] = time.perf_counter() - began
        run.complete(finite=finite)

    def _carry_out(self, calls: list[Call]) -> None:
        run = self._run
        t, h = run.start + run.tick * run.h, run.h
        for function, timed, unit in calls:
            try:
                status = function(t, h) if timed else function()
            except EndRequested as end:
                run.end(end)
                continue
            if status:
                run.checked(run.units[unit], status, function)
