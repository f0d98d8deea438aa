"""Staging: parts of a block's equations as functions of their own, so that the generated C stays small."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from components.interfaces.record import leaves, pack, unpack, variables

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
    flat = [leaf for a in arguments for leaf in leaves(a)]
    if not any(isinstance(leaf, ca.MX) for leaf in flat):
        return function(*arguments)
    columns, records = zip(*(symbols(type(a), dimensions, name=f"a{i}") for i, a in enumerate(arguments)), strict=True)
    # Loops in the equations give equal expressions many times.
    expressions = ca.cse(ca.SX(column_of(function(*records))))
    body = ca.Function(function.__name__.strip("_"), list(columns), [expressions])
    column: Any = body(*(pack(a) for a in arguments))
    return unpack(returns, column, dimensions)


def column_of(value: object) -> Any:
    """`pack(value)` as something CasADi takes as an expression, even when it is all numbers."""
    column = pack(value)
    return ca.DM(column) if isinstance(column, np.ndarray) else column
