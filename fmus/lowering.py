"""Lowering: a block's equations as CasADi functions of flat columns, the one source of units and of C."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from components.interfaces.block import Block, Sampled
from components.interfaces.staging import column_of, symbols


@dataclass(frozen=True)
class Lowered:
    """A block as functions of columns: parameters `p`, state `x`, inputs `u`, outputs `y`, step `h`."""

    block: type[Block[Any, Any, Any]]
    start: ca.Function
    """`start(p) -> x`"""
    output: ca.Function
    """`output(x, u, p) -> y`; what a sampled block would show if it sampled now"""
    step: ca.Function
    """`step(x, u, p, h) -> x`, or for a sampled block `step(x, u, p, h) -> (x, y)`"""
    sampled: bool
    feedthrough: NDArray[np.bool_]
    """(outputs, inputs), element by element: whether an input reaches an output without delay"""


@cache
def lower(kind: type[Block[Any, Any, Any]]) -> Lowered:
    """The functions of a block, derived once from its equations; feedthrough is read off them, not declared."""
    dims = kind.dimensions()
    graph: Any = ca.MX if kind.staged else ca.SX
    p, parameters = symbols(kind, dims, graph, "p")
    x, state = symbols(kind.state_type, dims, graph, "x")
    u, inputs = symbols(kind.input_type, dims, graph, "u")
    h = graph.sym("h")

    sampled = issubclass(kind, Sampled)
    if sampled:
        next_state, outputs = parameters.sample(state, inputs)
        results = [column_of(next_state), column_of(outputs)]
    else:
        outputs = parameters.output(state, inputs)
        results = [column_of(parameters.step(state, inputs, h))]
    y = column_of(outputs)
    output = ca.Function("output", [x, u, p], [y], ["x", "u", "p"], ["y"])
    return Lowered(
        block=kind,
        start=ca.Function("start", [p], [column_of(parameters.start())], ["p"], ["x"]),
        output=output,
        step=ca.Function("step", [x, u, p, h], results, ["x", "u", "p", "h"], ["x_next", "y"][: len(results)]),
        sampled=sampled,
        feedthrough=_feedthrough(output, sampled),
    )


def _feedthrough(output: ca.Function, sampled: bool) -> NDArray[np.bool_]:  # noqa: FBT001
    shape = (output.size1_out(0), output.size1_in(1))
    if sampled:
        return np.ones(shape, dtype=bool)
    pattern = np.zeros(shape, dtype=bool)
    rows, columns = output.jac_sparsity(0, 1).get_triplet()
    pattern[rows, columns] = True
    return pattern
