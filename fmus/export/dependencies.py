"""Which inputs and parameters an output depends on without delay, element by element."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from fmus.export.fmi_variables import FmiVariable, Interface
from fmus.lowering import Lowered


@dataclass(frozen=True)
class Dependencies:
    """What the outputs depend on: at every communication point, and in Initialization Mode."""

    interface: Interface
    on_inputs: NDArray[np.bool_]
    """(outputs, inputs)"""
    on_parameters: NDArray[np.bool_] | None
    """(outputs, parameters), through the start state too; None where it is not known: then it may be all"""

    def of(self, output: FmiVariable, rows: range) -> Callable[[FmiVariable], Sequence[int]]:
        """For the elements `rows` of an output: which elements of an input or a parameter they depend on."""
        first = self.interface.outputs[0].reference

        def depends(on: FmiVariable) -> Sequence[int]:
            matrix = self.on_inputs if on.causality == "input" else self.on_parameters
            if matrix is None:
                return range(on.variable.size)
            group = self.interface.inputs if on.causality == "input" else self.interface.parameters
            at = on.reference - group[0].reference
            begin = output.reference - first
            part = matrix[begin + rows.start : begin + rows.stop, at : at + on.variable.size]
            return [int(column) for column in np.flatnonzero(part.any(axis=0))]

        return depends


def dependencies(lowered: Lowered, interface: Interface) -> Dependencies:
    """Read off the block's functions."""
    if lowered.sampled:
        return Dependencies(interface, lowered.feedthrough, None)
    direct = _pattern(lowered.output, 0, 2)
    by_state = _pattern(lowered.output, 0, 0).astype(int) @ _pattern(lowered.start, 0, 0).astype(int) > 0
    return Dependencies(interface, lowered.feedthrough, direct | by_state)


def _pattern(function: ca.Function, result: int, argument: int) -> NDArray[np.bool_]:
    pattern = np.zeros((function.size1_out(result), function.size1_in(argument)), dtype=bool)
    rows, columns = function.jac_sparsity(result, argument).get_triplet()
    pattern[rows, columns] = True
    return pattern
