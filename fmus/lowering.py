"""Lowering: a block's equations as CasADi functions of flat columns, which both running units and C are made from."""
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
from components.interfaces.maths import is_symbolic
from components.interfaces.problem import Problem, RequestError, raise_if_any, refuse
from components.interfaces.record import leaves, variables
from components.interfaces.staging import column_of, symbols
from components.interfaces.symbol_problem import symbol_problem, symbols_without_values


@dataclass(frozen=True)
class LoweredBlock:
    """A block as functions of columns: parameters `p`, state `x`, inputs `u`, outputs `y`, step `h`."""

    block: type[Block[Any, Any, Any]]
    start: ca.Function
    """`start(p) -> x`."""
    output: ca.Function
    """`output(x, u, p) -> y`; for a sampled block, the outputs that it would have if it sampled now."""
    step: ca.Function
    """`step(x, u, p, h) -> x`, or for a sampled block `step(x, u, p, h) -> (x, y)`."""
    sampled: bool
    feedthrough: NDArray[np.bool_]
    """Whether an input reaches an output without delay, element by element, of shape (outputs, inputs)."""


@cache
def lower(block: type[Block[Any, Any, Any]]) -> LoweredBlock:
    """The functions of a block, derived once from its equations.

    An output depends on the inputs that its expression contains; that of a sampled block is taken to depend on all.

    Raises:
        RequestError: The equations do with symbols what only numbers can do, or give what is not declared.
    """
    try:
        with symbols_without_values():
            return _lowered(block)
    except RequestError:
        raise
    except Exception as error:
        if problem := symbol_problem(block, error):
            raise RequestError([problem]) from error
        raise


def _lowered(block: type[Block[Any, Any, Any]]) -> LoweredBlock:
    dims = block.dimensions()
    graph: Any = ca.MX if block.staged else ca.SX
    p, parameters = symbols(block, dims, graph, "p")
    x, state = symbols(block.state_type, dims, graph, "x")
    u, inputs = symbols(block.input_type, dims, graph, "u")
    h = graph.sym("h")

    sampled = issubclass(block, Sampled)
    if sampled:
        next_state, outputs = parameters.sample(state, inputs)
        results = [_column(block, block.state_type, next_state), _column(block, block.output_type, outputs)]
    else:
        outputs = parameters.output(state, inputs)
        results = [_column(block, block.state_type, parameters.step(state, inputs, h))]
    y = _column(block, block.output_type, outputs)
    output = ca.Function("output", [x, u, p], [y], ["x", "u", "p"], ["y"])
    all_depend = np.ones((output.size1_out(0), output.size1_in(1)), dtype=bool)
    return LoweredBlock(
        block=block,
        start=ca.Function("start", [p], [_column(block, block.state_type, parameters.start())], ["p"], ["x"]),
        output=output,
        step=ca.Function("step", [x, u, p, h], results, ["x", "u", "p", "h"], ["x_next", "y"][: len(results)]),
        sampled=sampled,
        feedthrough=all_depend if sampled else sparsity(output, 0, 1),
    )


def _column(block: type[Block[Any, Any, Any]], kind: type, record: Any) -> Any:
    """The column of a record. Raises `RequestError` where it is none of the type, or has values of another shape."""
    if not isinstance(record, kind):
        found = f"{type(record).__name__} from its equations"
        raise refuse(f"block `{block.name}`", found, kind.__name__, "Return one, with all of its fields.")
    pairs = zip(variables(kind, block.dimensions()), leaves(record), strict=True)
    raise_if_any(
        Problem(f"block `{block.name}`, {kind.__name__}: {v.name}", f"{n} values", f"{v.size}")
        for v, leaf in pairs
        if (n := leaf.numel() if is_symbolic(leaf) else np.size(leaf)) != v.size
    )
    return column_of(record)


def sparsity(function: ca.Function, result: int, argument: int) -> NDArray[np.bool_]:
    """The elements of a function's result that depend on each element of an argument.

    Args:
        function: The function.
        result: The index of the result, a column of `m` elements.
        argument: The index of the argument, a column of `n` elements.

    Returns:
        An array of shape `(m, n)`.
    """
    pattern = np.zeros((function.size1_out(result), function.size1_in(argument)), dtype=bool)
    rows, columns = function.jac_sparsity(result, argument).get_triplet()
    pattern[rows, columns] = True
    return pattern
