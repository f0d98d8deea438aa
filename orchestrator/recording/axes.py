"""The ranges of the plots' axes, so that each axis has numbers enough to read values from.

The viewer writes a number at multiples of a power of ten, and only where they have some room: an axis from -0.6 to 0.6
would show a single 0. A range is therefore widened until it holds two of the numbers that the viewer writes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final, TypeAlias

import numpy as np

from orchestrator.pictures.shapes import SeriesValues, Shape, Style

AxisRange: TypeAlias = tuple[float, float]
"""The lower and the upper end of an axis."""

_NUMBERS: Final = 4.5
"""Numbers at most for which a plot of the first page has room, in a window of 1280 x 800."""
_MARGIN: Final = 0.04
"""Share of the range that is left free above and below."""
_FLAT: Final = 1e-9
"""Of what is no wider than this share of its size the viewer finds a better range."""


class Extremes:
    """The smallest and the largest value of each series that has been drawn."""

    def __init__(self) -> None:
        self._of: dict[str, AxisRange] = {}

    def noted(self, shapes: Iterable[Shape | Style]) -> Iterator[Shape | Style]:
        """The same shapes, whose series are noted as they pass."""
        for shape in shapes:
            if isinstance(shape, SeriesValues):
                self._note(shape)
            yield shape

    def ranges(self) -> Mapping[str, AxisRange]:
        """The smallest and the largest value by entity; what has no number is left out."""
        return self._of

    def _note(self, series: SeriesValues) -> None:
        values = np.asarray(series.values, dtype=float)
        values = values[np.isfinite(values)]
        if len(values):
            low, high = self._of.get(series.entity, (math.inf, -math.inf))
            self._of[series.entity] = min(low, float(values.min())), max(high, float(values.max()))


def axis_range(extremes: Sequence[AxisRange]) -> AxisRange | None:
    """The range of an axis.

    Args:
        extremes: The smallest and the largest value of each series of the plot.

    Returns:
        A range in which two of the viewer's numbers lie; None where the viewer should choose it, because its own does,
        or because what there is does not change.
    """
    low, high = min((x for x, _ in extremes), default=0.0), max((x for _, x in extremes), default=0.0)
    if not high - low > _FLAT * max(abs(low), abs(high)):
        return None
    found = low, high
    step = 10.0 ** math.ceil(math.log10((high - low) / _NUMBERS))
    while math.floor(high / step) - math.ceil(low / step) < 1:
        below, above = (math.ceil(low / step) - 1) * step, (math.floor(high / step) + 1) * step
        low, high = (below, high) if low - below < above - high else (low, above)
    free = _MARGIN * (high - low)
    return None if (low, high) == found else (low - free, high + free)
