"""Prepared calls as data: Python carries them out by calling them, the native stepper from what they are made of."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from numpy.typing import NDArray

from components.interfaces.conversion import IDENTITY, Transformation
from fmus.units.unit import Column, Operation, carry_out

_LIBRARY_FUNCTION: Final = ctypes._CFuncPtr  # type: ignore[private] # noqa: SLF001 - no public name
"""The type of the functions that ctypes finds in a library."""


class AccessCall(partial[int]):
    """A call of a library's function that sets or gets values, with the addresses of all its arguments.

    These are the instance, the value references, their number, the values, and in FMI 3.0 the number of values.
    """


class Gather:
    """A copy of scattered values to where they lie side by side.

    Args:
        source: The values, (n,).
        places: The places of those that are copied, (m,).
        target: Where they go, (m,).
    """

    def __init__(self, source: Column, places: NDArray[Any], target: Column) -> None:
        self.source, self.places, self.target = source, places, target
        # mode "clip" lets numpy write to `target` without a copy; the places are in range by construction
        self._take = partial(source.take, places, None, target, "clip")

    def __call__(self) -> None:
        """Carry it out."""
        self._take()


class Copy:
    """A copy of values to another place, where they may have another type or another unit of measurement.

    Args:
        source: The values, (n,).
        target: Where they go, (n,).
        conversion: What becomes of each.
    """

    def __init__(self, source: Column, target: Column, conversion: Transformation = IDENTITY) -> None:
        self.source, self.target, self.conversion = source, target, conversion
        self._plain = conversion == IDENTITY

    def __call__(self) -> None:
        """Carry it out."""
        self.target[:] = self.source if self._plain else self.conversion(self.source)


class CallSeries:
    """Calls that are one operation.

    Args:
        calls: The calls, in order.
        name: The function of FMI that is called among them.
    """

    def __init__(self, calls: tuple[Operation, ...], name: str) -> None:
        self.calls = calls
        self.__name__ = name

    def __call__(self) -> int:
        """Carry out all, and return the worst FMI status."""
        return carry_out(self.calls)


@dataclass(frozen=True)
class StepCall:
    """The call of a library's function that steps an instance of FMI 2.0 or 3.0."""

    function: int
    """Address of the function."""
    component: int
    """Address of the instance."""
    results: tuple[int, ...]
    """In FMI 3.0, the addresses of what it says of the step: three flags, each a byte, and the time it has reached."""
    outcome: Callable[[int, float, float], object]
    """What `Unit.step` does with the status of a step from `t` of the length `h` [s]; needed unless all is as usual."""


def direct_step(
    function: Any, component: int, results: tuple[int, ...], outcome: Callable[[int, float, float], object]
) -> StepCall | None:
    """A `StepCall` of these, unless something stands before the library's function, such as a note of each call."""
    return StepCall(address_of(function), component, results, outcome) if is_direct(function) else None


def is_direct(function: Any) -> bool:
    """Whether a function is the library's own, before which nothing stands."""
    return isinstance(function, _LIBRARY_FUNCTION)


def address_of(function: Any) -> int:
    """The address of a library's function."""
    return int(ctypes.cast(function, ctypes.c_void_p).value or 0)
