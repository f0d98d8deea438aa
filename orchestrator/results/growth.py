"""Signals that grow without bound, as those of a unit do whose own integration is unstable with its step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any, Final

import numpy as np

_GROWN: Final = 1e6
"""How many times larger than in the first part of a run, and than 1, a value is that has grown without bound."""
_PARTS: Final = 4
"""The number of parts of a run in each of which it has to be larger than in the one before."""
_LEAST: Final = 8
"""The least number of rows of which this is told."""


def growth_remarks(columns: Mapping[str, Any], units: Iterable[str]) -> list[str]:
    """A remark on each unit that has signals which grow throughout a run, beyond all measure.

    Args:
        columns: The rows of the run; values that are not finite do not count.
        units: The names of the units.
    """
    found: dict[str, tuple[str, float]] = {}
    for name in columns:
        unit = name.partition(".")[0]
        peak = _grown(np.asarray(columns[name])) if unit in units else None
        if peak is not None and peak > found.get(unit, ("", 0.0))[1]:
            found[unit] = name, peak
    return [
        f"`{name}` grows without bound, up to {peak:.3g}: where the model is not of that nature, its step is"
        " too long; try a shorter --step"
        for name, peak in found.values()
    ]


def _grown(values: np.ndarray[Any, Any]) -> float | None:
    """The last size of a signal that grows without bound; None for any other."""
    if values.dtype.kind != "f":
        return None
    sizes = np.abs(values[np.isfinite(values)])
    if len(sizes) < _LEAST:
        return None
    peaks = [float(part.max()) for part in np.array_split(sizes, _PARTS)]
    grows = all(later > earlier for earlier, later in pairwise(peaks))
    return peaks[-1] if grows and peaks[-1] > _GROWN * max(1.0, peaks[0]) else None
