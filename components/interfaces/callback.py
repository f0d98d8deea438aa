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
    """A function of columns as a node of the equations, which is called with numbers only.

    The object has to be kept alive as long as the equations, because a node refers to its function without owning it.

    Args:
        name: Name of the node.
        function: Takes one column of each length in `sizes_in`, returns one column or number of each in `sizes_out`.
        sizes_in: Lengths of the columns that it takes.
        sizes_out: Lengths of the columns that it returns.
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
