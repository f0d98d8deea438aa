"""The end of a run before its stop time."""

from __future__ import annotations


class SimulationError(RuntimeError):
    """A run that had to end early; all rows up to that tick are kept.

    Args:
        tick: The tick at which it ended.
        t: The time of that tick [s].
        unit: The unit that failed, or whose signal is not finite; empty where no unit is to blame.
        reason: What happened, in words.
    """

    def __init__(self, tick: int, t: float, unit: str, reason: str) -> None:
        self.tick, self.time, self.unit, self.reason = tick, t, unit, reason
        of_unit = f", unit `{unit}`" if unit else ""
        super().__init__(f"tick {tick} (t = {t:g} s){of_unit}: {reason}")
