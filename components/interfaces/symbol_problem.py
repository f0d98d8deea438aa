"""What an equation does with a symbol that only a number can do: no signal has a value while C is made of it."""

# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import traceback
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import casadi
import numpy as np

from components.interfaces.block import Block
from components.interfaces.problem import Problem

_NO_VALUE = "a symbol has no value"
_NUMPY_AS_BEFORE = -1
"""The mode of CasADi in which functions of NumPy give symbols for symbols, without a warning."""
_SHOWN = 80
"""The characters of a line that a message shows."""
_LIBRARY = str(Path(casadi.__file__).parent)
_NOT_THEIRS = (_LIBRARY, str(Path(np.__file__).parent), __file__, "<")
_ERRORS = (
    (
        ("truth value",),
        "a decision on a signal",
        "an expression that has both cases: `maths.where(condition, a, b)`",
        "`from components import maths`; it has `both`, `either`, `negate`, `fmin` and `fmax` too.",
    ),
    (
        (_NO_VALUE, "to_int", "to_double", "as an integer", "not sx", "not mx", "non-integral"),
        "a function of numbers, given a signal",
        "a function of `maths`, such as `maths.sin`",
        "`from components import maths`; its functions take numbers and symbols alike.",
    ),
)
"""What CasADi and Python say, and what is to be said instead."""


@contextmanager
def symbols_without_values() -> Generator[None]:
    """Let no function of numbers take a symbol: CasADi gives it NaN for one, and equations would be wrong silently.

    Functions of NumPy that CasADi has too, such as `np.sin`, become CasADi's own. It warns that their result may be of
    another type one day, which nobody who writes a block can do anything about: this keeps today's type silently.
    """
    before, mode = casadi.SX.__float__, casadi.GlobalOptions.getNumpyMode()

    def value(self: Any) -> float:
        if not self.is_constant():
            raise TypeError(_NO_VALUE)
        return before(self)

    casadi.SX.__float__ = value
    casadi.GlobalOptions.setNumpyMode(_NUMPY_AS_BEFORE)
    try:
        yield
    finally:
        casadi.SX.__float__ = before
        casadi.GlobalOptions.setNumpyMode(mode)


def symbol_problem(block: type[Block[Any, Any, Any]], error: Exception) -> Problem | None:
    """What is wrong with a block's equations; None where the error is of another kind.

    Args:
        block: The block.
        error: What was raised while its equations were computed with symbols.
    """
    said = f"{error}".lower()
    known = next((told for signs, *told in _ERRORS if any(sign in said for sign in signs)), None)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith(_NOT_THEIRS)]
    if known is None or not frames:
        return None
    found, valid, remedy = known
    line = f" (`{frames[-1].line[:_SHOWN]}`)" if frames[-1].line else ""
    where = f"block `{block.name}`, {Path(frames[-1].filename).name}, line {frames[-1].lineno}"
    return Problem(where, f"{found}{line}, whose value is not known when the equations become C", valid, remedy)
