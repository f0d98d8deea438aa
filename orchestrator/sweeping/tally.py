"""How a sweep goes, in a line that a person can plan by."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from orchestrator.sweeping import ranking
from orchestrator.sweeping.journal import VariantResult
from orchestrator.sweeping.plan import PlannedSweep


class Tally:
    """How a sweep goes, in a line whenever somebody asks.

    Args:
        planned: The sweep.
        before: What was done before.
        clock: Gives the time [s].
    """

    def __init__(self, planned: PlannedSweep, before: Mapping[int, VariantResult], clock: Callable[[], float]) -> None:
        self._count, self._before, self._clock = len(planned), len(before), clock
        self._began = self._first = clock()
        self._done, self._failed = len(before), sum(bool(r.fault) for r in before.values())
        self._worst = min(before.values(), key=ranking.badness, default=None)

    @property
    def seconds(self) -> float:
        """[s] The time since this part of the sweep began."""
        return self._clock() - self._began

    def note(self, result: VariantResult) -> None:
        """Count a result."""
        if self._done == self._before:  # workers get ready until then
            self._first = self._clock()
        self._done += 1
        self._failed += bool(result.fault)
        if self._worst is None or ranking.badness(result) < ranking.badness(self._worst):
            self._worst = result

    def __call__(self) -> str:
        """The line."""
        text = f"{self._done} of {self._count} variants" if self._count else f"{self._done} variants"
        if self._failed:
            text += f", {self._failed} with a fault"
        passed = self._clock() - self._first
        if (new := self._done - self._before - 1) > 0 and passed > 0:
            rate = new / passed
            text += f", {rate:.3g} per second"
            text += f", {_span((self._count - self._done) / rate)} left" if self._count else ""
        if self._worst is not None:
            text += f"; worst so far: variant {self._worst.variant} ({ranking.in_words(self._worst)})"
        return text


def _span(seconds: float) -> str:
    if seconds < 100:  # noqa: PLR2004 - until then seconds are read easily
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"  # noqa: PLR2004
