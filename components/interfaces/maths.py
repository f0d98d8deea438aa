"""The mathematics that equations are written in: the same text for plain numbers and for CasADi symbols.

Annotations say `float` and `Array`; while a block is lowered to C the same names stand for symbols.
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

_SYMBOLIC = (ca.SX, ca.MX)


def is_symbolic(value: object) -> bool:
    """Whether `value` is a CasADi symbol or expression."""
    return isinstance(value, _SYMBOLIC)


def _either(symbolic: Callable[..., Any], numeric: Callable[..., Any]) -> Callable[..., Any]:
    def function(*arguments: Any) -> Any:
        return (symbolic if any(map(is_symbolic, arguments)) else numeric)(*arguments)

    return function


sin: Callable[[float], float] = _either(ca.sin, np.sin)
cos: Callable[[float], float] = _either(ca.cos, np.cos)
tan: Callable[[float], float] = _either(ca.tan, np.tan)
acos: Callable[[float], float] = _either(ca.acos, np.arccos)
tanh: Callable[[float], float] = _either(ca.tanh, np.tanh)
atan2: Callable[[float, float], float] = _either(ca.atan2, np.arctan2)
sqrt: Callable[[float], float] = _either(ca.sqrt, np.sqrt)
exp: Callable[[float], float] = _either(ca.exp, np.exp)
fmin: Callable[[float, float], float] = _either(ca.fmin, np.fmin)
fmax: Callable[[float, float], float] = _either(ca.fmax, np.fmax)
both: Callable[[Any, Any], bool] = _either(ca.logic_and, np.logical_and)
either: Callable[[Any, Any], bool] = _either(ca.logic_or, np.logical_or)
negate: Callable[[Any], bool] = _either(ca.logic_not, np.logical_not)
where: Callable[[Any, Any, Any], Any] = _either(ca.if_else, lambda c, a, b: np.where(c, a, b)[()])
"""`where(condition, a, b)`: both branches are evaluated, the unwanted one is dropped even when it is not a number."""


def absolute(value: float) -> float:
    """The absolute value."""
    return ca.fabs(value) if is_symbolic(value) else np.abs(value)


def sign(value: float) -> float:
    """The sign of a value: -1, 0 or 1."""
    return ca.sign(value) if is_symbolic(value) else np.sign(value)


def clip(value: float, low: float, high: float) -> float:
    """`value`, kept inside [low, high]."""
    return fmin(fmax(value, low), high)


def is_number(*values: float, limit: float = 1e300) -> bool:
    """Whether all values are numbers of a magnitude below `limit`; infinities are too large, and NaN is none."""
    known = absolute(values[0]) < limit  # false for NaN
    for value in values[1:]:
        known = both(known, absolute(value) < limit)
    return known


def largest(values: Sequence[float]) -> float:
    """The largest of several values."""
    result = values[0]
    for value in values[1:]:
        result = fmax(result, value)
    return result


def smallest(values: Sequence[float]) -> float:
    """The smallest of several values."""
    result = values[0]
    for value in values[1:]:
        result = fmin(result, value)
    return result


def _column(expression: Any) -> Array:
    return expression


def vector(values: Sequence[float]) -> Array:
    """One column of several values."""
    if any(map(is_symbolic, values)):
        return _column(ca.vertcat(*values))
    return np.array([float(value) for value in values])


def joined(parts: Sequence[Array]) -> Array:
    """Several columns, one below the other."""
    if any(map(is_symbolic, parts)):
        return _column(ca.vertcat(*parts))
    return np.concatenate([np.atleast_1d(np.asarray(part, dtype=float)) for part in parts]) if parts else np.zeros(0)
