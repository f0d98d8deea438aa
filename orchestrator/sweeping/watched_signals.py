"""The signals whose course is kept of the variants of a sweep, so that what they have in common can be shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from components.interfaces.buses import VehicleState
from components.interfaces.problem import Problem, did_you_mean, raise_if_any
from orchestrator.stepping.paces import paces
from orchestrator.system.experiment import Scenario
from orchestrator.system.shown import shown, signal_path

SIGNALS_OPTION: Final = "--signals"
_VARIANTS: Final = 1024
"""Variants whose signals are kept, at most: so many show a mean and a range as well as a million do."""
_GOLDEN: Final = 0x9E3779B97F4A7C15
"""The golden ratio, as a share of 2^64."""
_ROWS: Final = 512
"""Rows that are kept of a variant, at most: a picture has no room for more."""


@dataclass(frozen=True)
class WatchedSignals:
    """Signals that are kept of some variants, at every so manieth tick."""

    columns: Mapping[str, str] = field(default_factory=dict[str, str])
    """Their full paths, and their units of measurement."""
    share: float = 1.0
    """The share of the variants of which they are kept."""
    every_row: int = 1

    def in_words(self, count: int) -> str:
        """Of which variants they are kept.

        Args:
            count: The number of variants of the sweep.
        """
        some = sum(map(self.takes, range(count)))
        which = "all variants" if some == count else f"{some} of {count} variants, evenly spread"
        return (
            f"The mean, the range of 90 %, and the whole range of {which}. One that ended early counts until then; what"
            " is no finite number does not count."
        )

    def takes(self, variant: int) -> bool:
        """Whether the signals of a variant are kept.

        Multiples of the golden ratio are spread evenly, and those of every second number, or third, are as well, so
        that no value of a grid is left out.
        """
        return variant * _GOLDEN % 2**64 < self.share * 2**64

    def taken(self, variant: int, rows: Mapping[str, NDArray[np.float64]]) -> dict[str, bytes]:
        """What is kept of a variant: the values of each signal as bytes, which `values` reads.

        Args:
            variant: The number of the variant.
            rows: The columns of its run.
        """
        if not self.takes(variant):
            return {}
        there = [name for name in self.columns if name in rows]
        return {name: np.asarray(rows[name][:: self.every_row], dtype="<f8").tobytes() for name in there}


UNWATCHED: Final = WatchedSignals()
"""No signals."""


def values(kept: bytes) -> NDArray[np.float64]:
    """The values of a signal that was kept, `(rows,)`."""
    return np.frombuffer(kept, dtype="<f8")


def watched_signals(asked: Sequence[str], scenarios: Mapping[str, Scenario], count: int) -> WatchedSignals:
    """The signals that are kept of the variants of a sweep.

    Args:
        asked: Their full paths; place across the road and speed, as far as all scenarios show them, if there are none.
        scenarios: The scenarios of the sweep.
        count: The number of its variants.

    Raises:
        RequestError: A scenario shows no such number at every tick.
    """
    known = {filled: _numbers(scenario) for filled, scenario in scenarios.items()}
    raise_if_any(_problems(asked, known))
    paths = list(asked) or list(_usual(scenarios, known))
    ticks = max(scenario.grid.last_tick + 1 for scenario in scenarios.values())
    units = next(iter(known.values()))
    return WatchedSignals(
        {path: units[path] for path in paths}, min(1.0, _VARIANTS / max(count, 1)), max(1, -(-ticks // _ROWS))
    )


def _numbers(scenario: Scenario) -> dict[str, str]:
    """The elements of signals that are numbers and are recorded at every tick, and their units of measurement."""
    pace = paces(scenario.system, scenario.record)
    return {
        path: variable.quantity.unit
        for unit, source in scenario.system.units.items()
        for variable in source.interface.recorded
        if variable.quantity.type.is_number
        for path in (f"{unit}.{element}" for element in variable.elements)
        if pace[path] == 1
    }


def _usual(scenarios: Mapping[str, Scenario], known: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    buses = shown(next(iter(scenarios.values())).system)
    for path in (signal_path(buses, VehicleState, signal) for signal in ("y", "v_x")):
        units = {names.get(path) for names in known.values()}
        if None not in units and len(units) == 1:
            yield path


def _problems(asked: Sequence[str], known: Mapping[str, Mapping[str, str]]) -> Iterator[Problem]:
    for path in asked:
        units = {names[path]: filled for filled, names in known.items() if path in names}
        if len(units) > 1:
            told = ", ".join(f"[{unit}] with {filled}" for unit, filled in units.items())
            yield Problem(
                f"{SIGNALS_OPTION} {path}", told, "one unit of measurement in all units", "Sweep them one by one."
            )
        for filled, names in known.items():
            if path not in names:
                found = "no number that is recorded at every tick" + (f", with {filled}" if filled else "")
                valid = "a signal, such as plant.state.y"
                yield Problem(f"{SIGNALS_OPTION} {path}", found, valid, did_you_mean(path, sorted(names)))
