"""The classical Runge-Kutta method of order 4, on records."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from components.interfaces.record import combine

_X = TypeVar("_X")


def runge_kutta(derivative: Callable[[_X], _X], x: _X, h: float) -> _X:
    """One step along ``dx/dt = derivative(x)``.

    Args:
        derivative: The time derivative of a state, as a record of the type of the state.
        x: The state at the beginning of the step.
        h: The length of the step [s].

    Returns:
        The state at the end of the step.
    """
    k_1 = derivative(x)
    k_2 = derivative(combine(_along(h / 2), x, k_1))
    k_3 = derivative(combine(_along(h / 2), x, k_2))
    k_4 = derivative(combine(_along(h), x, k_3))
    return combine(_along(h), x, combine(_mean, k_1, k_2, k_3, k_4))


def _along(h: float) -> Callable[[Any, Any], Any]:
    return lambda value, slope: value + h * slope


def _mean(k_1: Any, k_2: Any, k_3: Any, k_4: Any) -> Any:
    return (k_1 + 2 * k_2 + 2 * k_3 + k_4) / 6
