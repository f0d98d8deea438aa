"""Python functions inside the equations: for libraries that do not become C."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
from typing_extensions import override

from components.interfaces.maths import Array


class Callback(ca.Callback):
    """A function of columns as a node of the equations: called with numbers only, whatever surrounds it.

    `sizes_in` and `sizes_out` give the lengths of the columns; the function returns one column, or number, per output.
    Keep the object: a node holds its function without owning it.
    """

    def __init__(
        self, name: str, function: Callable[..., Sequence[Any]], sizes_in: Sequence[int], sizes_out: Sequence[int]
    ) -> None:
        ca.Callback.__init__(self)
        self._function, self._sizes_in, self._sizes_out = function, tuple(sizes_in), tuple(sizes_out)
        self.construct(name, {})

    @override
    def get_n_in(self) -> int:
        return len(self._sizes_in)

    @override
    def get_n_out(self) -> int:
        return len(self._sizes_out)

    @override
    def get_sparsity_in(self, i: int) -> Any:
        return ca.Sparsity.dense(self._sizes_in[i], 1)

    @override
    def get_sparsity_out(self, i: int) -> Any:
        return ca.Sparsity.dense(self._sizes_out[i], 1)

    @override
    def eval(self, arguments: Any) -> Any:
        columns: list[Array] = [np.array(a).ravel() for a in arguments]
        return [ca.DM(result) for result in self._function(*columns)]
