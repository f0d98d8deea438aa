"""Ranges in which the blocks are tried: plausible values for every signal, state and parameter by its name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from tests.components.parameter_sets import block_values

RANGES = {"v_x": (1.5, 20.0), "psi": (-0.5, 0.5), "y": (-2.0, 5.0), "x": (0.0, 60.0), "T_r": (-160.0, 200.0)}


def within(variable: Variable) -> tuple[float, float]:
    """Bounds for the values of a variable."""
    last = variable.name.rsplit(".", 1)[-1]
    return RANGES.get(last, (0.0, 5.0) if variable.quantity.min is not None else (-1.0, 1.0))


@pytest.fixture(scope="session")
def columns() -> Callable[..., st.SearchStrategy[Any]]:
    """A strategy for the flat column of some variables."""

    def column(variables: tuple[Variable, ...]) -> st.SearchStrategy[np.ndarray]:
        elements: list[st.SearchStrategy[float]] = []
        for variable in variables:
            whole = variable.quantity.type is not Type.FLOAT64
            one = st.integers(0, 1).map(float) if whole else st.floats(*within(variable))
            elements += [one] * variable.size
        return st.tuples(*elements).map(lambda values: np.array(values, dtype=float))

    return column


@pytest.fixture(scope="session")
def instance() -> Callable[[Any], Any]:
    """A block with its default parameter set."""
    return lambda kind: kind(**block_values(kind.name))
