"""The gain of a linear-quadratic regulator with one input, written as symbols so that it becomes plain C.

For ``x' = A x + b u``, sampled every T_s with u held, the gain K of u = -K x minimises the sum of x'Qx + r u^2 (Q is
diagonal). Sampling and the Riccati equation are both computed by doubling:

    exp(M t) by its series for a small t, squared again and again;

    A <- A W A,   G <- G + A W G A',   H <- H + A' H W A   with W = (I + G H)^-1,   from A, G = b b'/r, H = Q

after which H is what as many Riccati iterations as 2^rounds give. The number of rounds is fixed.

Reference: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77 (2004), structure-preserving doubling.
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from components.interfaces.maths import Array, is_symbolic, joined

DOUBLINGS = 16
"""The number of doublings: 65536 Riccati iterations, enough for any time constant far below 65536 T_s."""
SQUARINGS = 6
TERMS = 10
"""The number of terms of the exponential series, which is summed at T_s / 64."""


def gain(rows: list[Array], b: Array, q: Array, r: float, T_s: float) -> Array:
    """The gain of the regulator; numbers or symbols.

    Args:
        rows: The rows of A, each of shape (n,).
        b: Input column, of shape (n,).
        q: Diagonal of Q, of shape (n,).
        r: Weight of the input.
        T_s: Sampling time [s].

    Returns:
        K, of shape (n,).
    """
    K: Any = _function(len(rows))(joined(rows), b, q, r, T_s)
    return K if is_symbolic(K) else np.asarray(K, dtype=float).ravel()


@cache
def _function(n: int) -> ca.Function:
    rows, b, q = ca.MX.sym("rows", n * n), ca.MX.sym("b", n), ca.MX.sym("q", n)
    r, T_s = ca.MX.sym("r"), ca.MX.sym("T_s")
    square, double, last = _square(n + 1), _double(n), _last(n)
    # the state and its held input in one: exp([A b; 0 0] T_s) = [A_d b_d; 0 1]
    M = ca.vertcat(ca.horzcat(ca.reshape(rows, n, n).T, b), ca.MX(ca.DM.zeros(1, n + 1)))
    E = _series(n + 1)(M, T_s / 2**SQUARINGS)
    for _ in range(SQUARINGS):
        E = square(E)
    A_d, b_d = E[:n, :n], E[:n, n]
    A, G, H = A_d, b_d @ b_d.T / r, ca.diag(q)
    for _ in range(DOUBLINGS):
        A, G, H = double(A, G, H)
    return ca.Function("lqr_gain", [rows, b, q, r, T_s], [last(A_d, b_d, H, r)])


def _series(n: int) -> ca.Function:
    M, t = ca.SX.sym("M", n, n), ca.SX.sym("t")
    E = ca.SX.eye(n)
    for k in range(TERMS, 0, -1):
        E = ca.SX.eye(n) + M @ E * t / k
    return ca.Function("series", [M, t], [ca.densify(E)])


def _square(n: int) -> ca.Function:
    E = ca.SX.sym("E", n, n)
    return ca.Function("square", [E], [E @ E])


def _double(n: int) -> ca.Function:
    A, G, H = (ca.SX.sym(name, n, n) for name in "AGH")
    W_A, W_G = ca.horzsplit(ca.solve(ca.SX.eye(n) + G @ H, ca.horzcat(A, G)), n)
    return ca.Function("double_riccati", [A, G, H], [A @ W_A, G + A @ W_G @ A.T, H + A.T @ H @ W_A])


def _last(n: int) -> ca.Function:
    A, b, H, r = ca.SX.sym("A", n, n), ca.SX.sym("b", n), ca.SX.sym("H", n, n), ca.SX.sym("r")
    return ca.Function("gain_of", [A, b, H, r], [A.T @ (H @ b) / (r + b.T @ H @ b)])
