"""The mathematics that equations are written in: the same text for plain numbers and for CasADi symbols.

Annotations say `float` and `Array`; while a block is lowered to C the same names stand for symbols.
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

_SYMBOLIC = ("SX", "MX")
_PLAIN = frozenset((float, int, bool, np.float64, np.int64, np.bool_))
"""Types of numbers."""


def is_symbolic(value: object) -> bool:
    """Whether `value` is a CasADi symbol or expression."""
    kind = type(value)
    if kind in _PLAIN:
        return False
    return kind.__name__ in _SYMBOLIC and kind.__module__.startswith("casadi")


def _symbolic(name: str) -> Callable[..., Any]:
    """A function of CasADi, which is slow to import: processes that compute with numbers only do without it."""
    return getattr(import_module("casadi"), name)


def _either(symbolic: str, numeric: Callable[..., Any]) -> Callable[..., Any]:
    def function(*arguments: Any) -> Any:
        for argument in arguments:
            if type(argument) not in _PLAIN:
                break
        else:  # the usual case, in which the questions below would cost more than all the rest
            return numeric(*arguments)
        if any(isinstance(a, np.ndarray) and a.dtype.kind == "O" for a in arguments):  # whose elements may be symbols
            return np.frompyfunc(function, len(arguments), 1)(*arguments)
        return (_symbolic(symbolic) if any(map(is_symbolic, arguments)) else numeric)(*arguments)

    return function


sin: Callable[[float], float] = _either("sin", np.sin)
cos: Callable[[float], float] = _either("cos", np.cos)
tan: Callable[[float], float] = _either("tan", np.tan)
acos: Callable[[float], float] = _either("acos", np.arccos)
tanh: Callable[[float], float] = _either("tanh", np.tanh)
atan2: Callable[[float, float], float] = _either("atan2", np.arctan2)
hypot: Callable[[float, float], float] = _either("hypot", np.hypot)
sqrt: Callable[[float], float] = _either("sqrt", np.sqrt)
exp: Callable[[float], float] = _either("exp", np.exp)
fmin: Callable[[float, float], float] = _either("fmin", np.fmin)
fmax: Callable[[float, float], float] = _either("fmax", np.fmax)
both: Callable[[Any, Any], bool] = _either("logic_and", np.logical_and)
either: Callable[[Any, Any], bool] = _either("logic_or", np.logical_or)
negate: Callable[[Any], bool] = _either("logic_not", np.logical_not)
where: Callable[[Any, Any, Any], Any] = _either("if_else", lambda c, a, b: np.where(c, a, b)[()])
"""`where(condition, a, b)`: both branches are evaluated, the unwanted one is dropped even when it is not a number."""


def absolute(value: float) -> float:
    """The absolute value."""
    return _symbolic("fabs")(value) if is_symbolic(value) else np.abs(value)


def sign(value: float) -> float:
    """The sign of a value: -1, 0 or 1."""
    return _symbolic("sign")(value) if is_symbolic(value) else np.sign(value)


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
        return _column(_symbolic("vertcat")(*values))
    return np.array([float(value) for value in values])


def joined(parts: Sequence[Array]) -> Array:
    """Several columns, one below the other."""
    if any(map(is_symbolic, parts)):
        return _column(_symbolic("vertcat")(*parts))
    return np.concatenate([np.atleast_1d(np.asarray(part, dtype=float)) for part in parts]) if parts else np.zeros(0)
