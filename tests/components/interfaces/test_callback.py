"""Python functions inside equations: called with numbers, in the place and the shape they are declared for."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from components.interfaces.callback import Callback


@pytest.fixture
def called():
    return []


@pytest.fixture
def node(called):
    def function(a, b):
        called.append((a.tolist(), b.tolist()))
        return a * b[0], float(a.sum())

    return Callback("scaled", function, [3, 1], [3, 1])


def test_it_is_called_with_columns_of_numbers(node, called):
    first, second = node([1.0, 2.0, 3.0], 2.0)
    assert np.asarray(first).ravel().tolist() == [2.0, 4.0, 6.0]
    assert float(second) == 6.0
    assert called == [([1.0, 2.0, 3.0], [2.0])]


def test_it_is_a_node_of_an_expression(node):
    x = ca.MX.sym("x", 3)
    first, second = node(ca.sin(x), 2.0)
    whole = ca.Function("whole", [x], [first + second])
    x_value = np.array([0.1, 0.2, 0.3])
    expected = 2 * np.sin(x_value) + np.sin(x_value).sum()
    assert np.asarray(whole(x_value)).ravel() == pytest.approx(expected, rel=1e-15)


def test_every_output_is_taken_to_depend_on_every_input(node):
    x = ca.MX.sym("x", 3)
    whole = ca.Function("whole", [x], [node(x, 2.0)[0]])
    assert whole.jac_sparsity(0, 0).nnz() == 9


def test_what_is_not_a_number_passes_through():
    node = Callback("lost", lambda a: [np.full(a.size, np.nan)], [2], [2])
    assert np.isnan(np.asarray(node([1.0, 2.0]))).all()
