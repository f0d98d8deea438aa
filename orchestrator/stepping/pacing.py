"""Pacing a run against the wall clock."""

from __future__ import annotations

import time
from typing import Any

from components.interfaces.problem import refuse


class Pacer:
    """Begins tick k at the wall time `k h / factor` after the first, computed from k alone so that nothing drifts.

    A tick is late when its row was not complete before the next one was due. The ticks after a late one begin at once
    until the schedule is met again.

    Args:
        factor: Seconds to simulate in a second of wall time.
        h: The macro step [s].

    Raises:
        RequestError: The factor is not a positive number.
    """

    def __init__(self, factor: float, h: float) -> None:
        if not 0 < factor < float("inf"):
            raise refuse("--realtime", f"{factor:g}", "a positive number: 1 is real time, 2 twice as fast")
        self._factor, self._period = factor, h / factor
        self._start = 0.0
        self._late, self._worst = 0, 0.0

    def wait(self, tick: int) -> None:
        """Return when a tick is due, or at once if that time has passed."""
        if tick == 0:
            self._start = time.perf_counter()
        left = self._start + tick * self._period - time.perf_counter()
        if left > 0:
            time.sleep(left)

    def done(self, tick: int) -> None:
        """Note that a tick is complete."""
        beyond = time.perf_counter() - (self._start + (tick + 1) * self._period)
        if beyond > 0:
            self._late += 1
            self._worst = max(self._worst, beyond)

    def report(self) -> dict[str, Any]:
        """What a summary says of it: the factor, how many ticks were late, and by how much the worst one [s]."""
        return {"factor": self._factor, "late_ticks": self._late, "worst_s": self._worst}
