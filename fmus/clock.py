"""The clocks that an FMI 3.0 model description declares."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any, Final

SET_BY_IMPORTER: Final = frozenset({"fixed", "tunable"})
"""Interval variabilities of clocks whose interval the importer sets where the description gives none."""


@dataclass(frozen=True)
class Clock:
    """One clock: a time-based one ticks after an interval, a triggered one when another unit makes it tick."""

    name: str
    causality: str
    """`input`, `output` or `local`."""
    interval_variability: str
    """`constant`, `fixed`, `tunable`, `changing`, `countdown` or `triggered`."""
    reference: int
    """The value reference."""
    interval: float | None = None
    """[s] The interval; `None` where the description gives none."""
    shift: float = 0.0
    """[s] The delay of the first tick."""

    @property
    def is_time_based(self) -> bool:
        """Whether the importer makes it tick when its time has come."""
        return self.causality == "input" and self.interval_variability != "triggered"

    @property
    def is_triggered_input(self) -> bool:
        """Whether an output clock of another unit makes it tick."""
        return self.causality == "input" and self.interval_variability == "triggered"


def clock_of(element: Any) -> Clock:
    """One clock, of its element.

    Raises:
        ValueError: A number is none, or no time.
    """
    resolution = float(element.get("resolution", 0.0))
    interval, shift = element.get("intervalDecimal"), element.get("shiftDecimal")
    if interval is None and resolution and element.get("intervalCounter") is not None:
        interval = float(element.get("intervalCounter")) / resolution
    if shift is None:
        shift = float(element.get("shiftCounter", 0.0)) / resolution if resolution else 0.0
    times = float(interval or 0.0), float(shift)
    if not all(isfinite(time) and time >= 0 for time in times):
        raise ValueError(f"an interval of {times[0]:g} s and a shift of {times[1]:g} s")
    return Clock(
        name=element.get("name"),
        causality=element.get("causality", "local"),
        interval_variability=element.get("intervalVariability", "triggered"),
        reference=int(element.get("valueReference")),
        interval=None if interval is None else float(interval),
        shift=float(shift),
    )
