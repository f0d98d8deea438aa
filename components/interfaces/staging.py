"""Staging: parts of a block's equations as functions of their own, so that the generated C stays small."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from components.interfaces.maths import is_symbolic, where
from components.interfaces.record import combine, leaves, pack, unpack, variables

_Y = TypeVar("_Y")


def symbols(kind: type, dimensions: dict[str, int], graph: Any = ca.SX, name: str = "x") -> tuple[Any, Any]:
    """Fresh symbols for a record.

    Args:
        kind: The type of the record.
        dimensions: The structural constants that give its array lengths.
        graph: CasADi's type of symbols, `SX` or `MX`.
        name: Name of the column in the equations.

    Returns:
        The column, of shape (size(kind),), and the record made of it.
    """
    n = sum(v.size for v in variables(kind, dimensions))
    column = graph.sym(name, n)
    return column, unpack(kind, column, dimensions)


def staged(function: Callable[..., _Y], returns: type[_Y], dimensions: dict[str, int], *arguments: Any) -> _Y:
    """`function(*arguments)`, where `arguments` and the result are records.

    With plain numbers or scalar symbols (`SX`) this is the call itself. With graph symbols (`MX`) the call becomes
    one node: the equations are lowered once, as scalar operations, to a function that the generated C calls.

    Args:
        function: The equations; its name becomes that of the function in C.
        returns: The type of the result.
        dimensions: The structural constants that give array lengths.
        arguments: Records of numbers or symbols.
    """
    if not any(isinstance(leaf, ca.MX) for leaf in _all_leaves(arguments)):
        return function(*arguments)
    column: Any = _lowered(function, dimensions, arguments)(*(pack(a) for a in arguments))
    return unpack(returns, column, dimensions)


def staged_if(
    condition: Any, function: Callable[..., _Y], returns: type[_Y], dimensions: dict[str, int], *arguments: Any
) -> _Y:
    """`function(*arguments)` where a condition holds, and a record of zeros elsewhere.

    With symbols of either kind the call stands behind an `if` in the generated C: where the condition does not hold,
    the equations cost no time. (`where` evaluates both of its branches.)

    Args:
        condition: Whether the result is needed.
        function: The equations; its name becomes that of the function in C.
        returns: The type of the result.
        dimensions: The structural constants that give array lengths.
        arguments: Records of numbers or symbols.
    """
    if not any(map(is_symbolic, (condition, *_all_leaves(arguments)))):
        return combine(lambda value: where(condition, value, 0.0), function(*arguments))
    body = _lowered(function, dimensions, arguments)
    zeros = ca.Function("zeros", body.sx_in(), [ca.DM.zeros(body.sparsity_out(0).shape)])
    choice = ca.Function.if_else("choice", body, zeros)
    inputs = choice.mx_in()
    # scalar symbols call only what must not be inlined
    call = ca.Function(f"{body.name()}_if", inputs, choice.call(inputs), {"never_inline": True})
    return unpack(returns, call(condition, *(pack(a) for a in arguments)), dimensions)


def _all_leaves(arguments: tuple[Any, ...]) -> list[Any]:
    return [leaf for a in arguments for leaf in leaves(a)]


def _lowered(function: Callable[..., Any], dimensions: dict[str, int], arguments: tuple[Any, ...]) -> ca.Function:
    """The equations as a function of the columns of their arguments, by scalar operations."""
    columns, records = zip(*(symbols(type(a), dimensions, name=f"a{i}") for i, a in enumerate(arguments)), strict=True)
    # Loops in the equations give equal expressions many times.
    expressions = ca.cse(ca.SX(column_of(function(*records))))
    return ca.Function(function.__name__.strip("_"), list(columns), [expressions])


def column_of(value: object) -> Any:
    """`pack(value)` as something CasADi takes as an expression, even when it is all numbers."""
    column = pack(value)
    return ca.DM(column) if isinstance(column, np.ndarray) else column
