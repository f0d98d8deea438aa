"""The gain of the regulator against scipy's solution of the sampled Riccati equation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are
from scipy.signal import cont2discrete

from components.controller.algorithms import riccati


def known(A, b, q, r, T_s):
    """The gain and the closed loop by scipy."""
    A_d, b_d, *_ = cont2discrete((A, b, np.eye(len(A)), np.zeros_like(b)), T_s)
    P = solve_discrete_are(A_d, b_d, np.diag(q), np.array([[r]]))
    K = np.linalg.solve(r + b_d.T @ P @ b_d, b_d.T @ P @ A_d)
    return K.ravel(), A_d - b_d @ K


@pytest.mark.parametrize("q_delta", [1e-3, 0.1, 10.0, 1e3, 1e5])
@pytest.mark.parametrize("T_s", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("v_ref", [3.0, 10.0, 25.0])
def test_the_gain_of_the_vehicle_is_that_of_scipy(make, q_delta, T_s, v_ref):
    block = make("lqr", q_delta=q_delta, T_s=T_s, v_ref=v_ref)
    rows, b = block.error_dynamics(v_ref)
    q = [block.q_e, block.q_e_dot, block.q_psi, block.q_psi_dot]
    expected, closed = known(np.array(rows), b[:, None], q, q_delta, T_s)
    K = block.gain()
    assert [K.e, K.e_dot, K.psi_e, K.psi_e_dot] == pytest.approx(expected, rel=1e-5, abs=1e-6 * np.abs(expected).max())
    assert np.abs(np.linalg.eigvals(closed)).max() < 1


@given(seed=st.integers(0, 10_000), n=st.integers(1, 5))
def test_the_gain_of_any_controllable_system_is_that_of_scipy(seed, n):
    random = np.random.default_rng(seed)
    A, b = random.normal(size=(n, n)), random.normal(size=(n, 1))
    q = random.uniform(0.1, 2.0, size=n)
    expected, closed = known(A, b, q, 0.5, 0.1)
    assume(np.abs(np.linalg.eigvals(closed)).max() <= 0.995)  # else hardly controllable: scipy itself is not sure
    found = riccati.gain(list(A), b.ravel(), q, 0.5, 0.1)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-6 * np.abs(expected).max())


def test_a_double_integrator_at_a_long_step():
    expected, _ = known(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), [1.0, 0.0], 1.0, 1.0)
    found = riccati.gain([np.array([0.0, 1.0]), np.array([0.0, 0.0])], np.array([0.0, 1.0]), np.array([1.0, 0.0]), 1, 1)
    assert found == pytest.approx(expected, rel=1e-12)
