"""The inputs and parameters on which an output depends without delay, element by element."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.export.fmi_variables import FmiVariable, FmiVariables
from fmus.lowering import LoweredBlock, sparsity


@dataclass(frozen=True)
class Dependencies:
    """The inputs and parameters on which outputs depend: at communication points and in Initialization Mode."""

    variables: FmiVariables
    on_inputs: NDArray[np.bool_]
    """Whether an output depends on an input, of shape (outputs, inputs)."""
    on_parameters: NDArray[np.bool_] | None
    """The same for parameters, also through the start state, of shape (outputs, parameters); None for all of them."""

    def of(self, output: FmiVariable, rows: range) -> Callable[[FmiVariable], Sequence[int]]:
        """The dependencies of some elements of an output.

        Args:
            output: The output.
            rows: Its elements.

        Returns:
            A function that gives, for an input or a parameter, its elements on which the output depends.
        """
        first = self.variables.outputs[0].reference

        def depends(on: FmiVariable) -> Sequence[int]:
            matrix = self.on_inputs if on.causality == "input" else self.on_parameters
            if matrix is None:
                return range(on.variable.size)
            group = self.variables.inputs if on.causality == "input" else self.variables.parameters
            at = on.reference - group[0].reference
            begin = output.reference - first
            part = matrix[begin + rows.start : begin + rows.stop, at : at + on.variable.size]
            return [int(column) for column in np.flatnonzero(part.any(axis=0))]

        return depends


def dependencies(lowered: LoweredBlock, variables: FmiVariables) -> Dependencies:
    """The dependencies of a block's outputs, as its functions have them."""
    if lowered.sampled:
        return Dependencies(variables, lowered.feedthrough, None)
    direct = sparsity(lowered.output, 0, 2)
    by_state = sparsity(lowered.output, 0, 0).astype(int) @ sparsity(lowered.start, 0, 0).astype(int) > 0
    return Dependencies(variables, lowered.feedthrough, direct | by_state)
