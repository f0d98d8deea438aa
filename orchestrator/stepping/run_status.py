"""How far a run has come, and what ends it: what both steppers act on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from components.interfaces.problem import refuse
from fmus.units.unit import EndRequested, Unit, UnitError, is_failure
from orchestrator.stepping.rows import RowLog
from orchestrator.stepping.running_units import failure_reason
from orchestrator.stepping.simulation_error import SimulationError
from orchestrator.system.experiment import TimeGrid


class RunStatus:
    """How far a run has come.

    Args:
        grid: The ticks.
        log: The rows.
        units: All running units by name, as they are while it runs.
    """

    def __init__(self, grid: TimeGrid, log: RowLog, units: Mapping[str, Unit]) -> None:
        self.start, self.h, self.last_tick = grid.start, grid.h, grid.last_tick
        self.log = log
        self.units = units
        self.tick = -1
        """The last tick that is complete, or that something failed at."""
        self.ended: EndRequested | None = None
        """What ends the run before its stop time without a fault: a unit that asked for it."""
        self.under_way = False
        """Whether a step has been begun and not been completed, as after Ctrl-C in the midst of one."""
        self.step_times = np.zeros(grid.last_tick + 1)
        """[s] Wall time of each macro step."""

    def begin_anew(self) -> None:
        """Go back to before the first step."""
        self.go_to(-1, None)
        self.step_times = np.zeros(self.last_tick + 1)

    def go_to(self, tick: int, ended: EndRequested | None) -> None:
        """Go back, or on, to a tick that is complete."""
        self.tick, self.ended, self.under_way = tick, ended, False

    def check_complete(self) -> None:
        """Refuse to go on from the midst of a step. Raises `RequestError`."""
        if self.under_way:
            found = f"a step that was interrupted after {self.time:g} s"
            raise refuse("simulation", found, "one whose last step is complete", "Call `reset`, or `restore`.")

    @property
    def time(self) -> float:
        """The present instant [s]; the start time before the first step."""
        return float(self.log.times[max(self.tick, 0)])

    @property
    def is_over(self) -> bool:
        """Whether the stop time is reached, or a unit has asked for the end."""
        return self.tick >= self.last_tick or (self.ended is not None and self.tick >= 0)

    def end(self, end: EndRequested) -> None:
        """Note that a unit has asked for the end."""
        self.ended = self.ended or end

    def checked(self, unit: Unit, status: object, function: object = None) -> None:
        """Note a warning, which a unit's call has returned; raises `UnitError` for the status of a failure."""
        if isinstance(status, int) and is_failure(status):
            raise UnitError(unit.name, failure_reason(unit, status, function), ())
        unit.warned(status)

    def shorten(self) -> None:
        """Give the last row the time at which a single unit came to its end."""
        if self.ended is not None and len(self.units) == 1:
            self.log.shorten(self.tick, min(self.ended.time, self.time))

    def complete(self, *, finite: bool) -> None:
        """Note that the present tick has its row.

        Args:
            finite: Whether the run may go on with its values.

        Raises:
            SimulationError: It may not, or something else does not let it go on.
        """
        self.log.kept = self.tick + 1
        if not finite:
            raise SimulationError(self.tick, self.time, *self.log.finiteness.fault())
        if self.log.halted:
            raise SimulationError(self.tick, self.time, "", self.log.halted)
