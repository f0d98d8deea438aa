"""Signals of a socket of which a foreign unit has the rate of change: inputs that it follows, outputs that add up."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from fmus.units.adaptation import RateInput, VariableElement
from fmus.units.unit import Column, Operation


class RunningRate:
    """The rate that leads to a signal of ours by the end of the step."""

    def __init__(self, declared: RateInput) -> None:
        self._declared = declared
        self.kept = 0.0
        """The present value of the signal, as far as the adapter can compute it; 0 at the start."""

    def bind(self, ours: Mapping[str, Column], inputs: Mapping[str, Column], outputs: Mapping[str, Column]) -> None:
        """Use the columns of our inputs, and of the foreign unit's inputs and outputs, by variable."""
        rate, present = self._declared.rate, self._declared.present
        self._wanted = ours[rate.signal]
        self._rate = _element(inputs, rate.theirs[0])
        self._present = _element(outputs, present.theirs[0]) if present else None

    def act(self, h: float) -> None:
        """Set the rate for a step of `h` [s]."""
        present = self._declared.present
        if present is not None and self._present is not None:
            self.kept = float(present.relation(self._present[0]))
        limit, rate = self._declared.limit, self._declared.rate
        value = min(max((float(self._wanted[0]) - self.kept) / h, -limit), limit)
        self.kept += h * value
        self._rate[0] = min(max(rate.relation.inverse(value), rate.low), rate.high)


class RunningIntegral:
    """A signal of ours that is the integral of the rate that the foreign unit shows, updated once per step."""

    def __init__(self) -> None:
        self.begin_anew()

    def begin_anew(self) -> None:
        """Go back to the start, where it is 0."""
        self.value = self.shown = self.h = 0.0

    def begin(self, h: float) -> None:
        """Begin a step of `h` [s], from what was shown last."""
        self.value, self.h = self.shown, h

    def shown_in(self, slot: NDArray[Any]) -> Operation:
        """A call that turns the rate in a slot into the signal."""

        def show() -> None:
            self.shown = slot[0] = self.value + self.h * float(slot[0])

        return show


def _element(slots: Mapping[str, Column], place: VariableElement) -> Column:
    name, element = place
    return slots[name][element : element + 1]
