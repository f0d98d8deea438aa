"""Gauss-Newton trajectory optimisation by stages (iterative LQR), written as symbols so that it becomes plain C.

    minimise   sum over i < N of |residual(x_i, u_i)|^2  +  |residual(x_N, 0)|^2
    subject to x_{i+1} = step(x_i, u_i),   lower <= u_i <= upper

Each iteration linearises every stage along the present trajectory, sweeps backwards for a correction of the inputs
``u_i + alpha k_i + K_i (x - x_i)`` and keeps the best of several step lengths alpha, or the old inputs. Inputs that a
correction would push over a bound are clamped there, their feedback is zero. Work and memory grow linearly with N.
The search ends with the first iteration whose full correction is too small to matter.

A residual ``sqrt(w) max(0, g)`` is the constraint g <= 0 with a slack that costs w times its square, the slack
eliminated: it weighs nothing while the constraint holds.

References: Y. Tassa, N. Mansard, E. Todorov, Control-limited differential dynamic programming (2014);
D. H. Jacobson, D. Q. Mayne, Differential Dynamic Programming (1970).
"""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from components.controller.algorithms.repetition import repeated
from components.interfaces.maths import Array, is_symbolic
from components.interfaces.record import pack, size, unpack
from components.interfaces.staging import column_of, symbols

_STEP_LENGTHS = (1.0, 0.5, 0.2, 0.05)
_SMALLEST_DAMPING = 1e-6
_LARGEST_DAMPING = 1e6
_NO_CORRECTION = 1e-9
"""The largest correction of an input that does not matter."""


@dataclass(frozen=True)
class Stages:
    """A problem by stages: types of constants, stage data, state and input, and its functions of these records."""

    constants: type
    stage: type
    state: type
    input: type
    step: Callable[[Any, Any, Any], Any]
    """``step(constants, x, u) -> x``"""
    residual: Callable[[Any, Any, Any, Any], list[float]]
    """``residual(constants, stage, x, u) -> weighted residuals``"""
    bounds: Callable[[Any], tuple[Any, Any]]
    """``bounds(constants) -> lower, upper`` inputs."""


@dataclass(frozen=True)
class Trajectory:
    """The result of a search; columns hold one record below the other, step by step."""

    u: Any
    """Inputs, of shape (n_u N,)."""
    x: Any
    """States, of shape (n_x (N + 1),)."""
    cost: float
    decrease: float
    """Relative decrease of the cost in the last iteration."""
    iterations: float
    """Iterations that lowered the cost."""


def optimise(  # noqa: PLR0913 - the parts of the problem
    stages: Stages, constants: Any, data: Any, x_start: Any, u_start: Array, *, N: int, iterations: int
) -> Trajectory:
    """Improve inputs iteration by iteration; numbers or graph symbols.

    Args:
        stages: The problem.
        constants: Its constants, a record of the type that `stages` names.
        data: Stage data, of shape (n_stage (N + 1),), one record below the other.
        x_start: The state at the first stage, a record.
        u_start: The inputs that the search begins with, of shape (n_u N,), one record below the other.
        N: Number of stages with an input.
        iterations: How many are made at most.

    Returns:
        The best trajectory, which is that of `u_start` where no iteration lowered the cost.
    """
    search, roll = _functions(stages, N, iterations)
    n_u = size(stages.input)
    p, x_0 = pack(constants), pack(x_start)
    u: Any = ca.reshape(u_start, n_u, N)
    table = ca.reshape(data, size(stages.stage), N + 1)
    x, cost = roll(p, table, x_0, u)
    u, x, cost, before, count, _ = search(u, x, cost, cost, 0.0, 0.0, p, table, x_0)
    best = Trajectory(ca.vec(u), ca.vec(x), cost, (before - cost) / (1e-9 + ca.fabs(cost)), count)
    if is_symbolic(cost):
        return best
    u, x = (np.asarray(column, dtype=float).ravel() for column in (best.u, best.x))
    return Trajectory(u, x, float(best.cost), float(best.decrease), float(best.iterations))


@cache
def _functions(stages: Stages, N: int, iterations: int) -> tuple[ca.Function, ca.Function]:
    """The search, and the trajectory of given inputs; loops over the stages, so that the C stays small."""
    n_x, n_u = size(stages.state), size(stages.input)
    p = ca.MX.sym("p", size(stages.constants))
    data = ca.MX.sym("data", size(stages.stage), N + 1)
    x_0, u, x = ca.MX.sym("x_0", n_x), ca.MX.sym("u", n_u, N), ca.MX.sym("x", n_x, N + 1)
    k, K, alpha = ca.MX.sym("k", n_u, N), ca.MX.sym("K", n_u, n_x * N), ca.MX.sym("alpha")
    corrected = _corrected(stages, N, (p, data, x_0, u, x, k, K, alpha))

    damping, cost, before, count = (ca.MX.sym(name) for name in ("damping", "cost", "before", "count"))
    k_all, K_all = _gains(stages, N, p, data, u, x, damping)
    best = u, x, cost, ca.MX(0)
    for length in reversed(_STEP_LENGTHS):
        trial = corrected(p, data, x_0, u, x, k_all, K_all, length)
        better = trial[2] < best[2]
        best = tuple(ca.if_else(better, new, old) for new, old in zip((*trial, ca.MX(length)), best, strict=True))
    worse = ca.fmin(ca.fmax(10 * damping, _SMALLEST_DAMPING), _LARGEST_DAMPING)
    next_damping = ca.if_else(best[3] <= 0, worse, damping / 10)
    # Damping makes the corrections small, too, so that small ones say nothing while there is much of it.
    done = ca.logic_and(ca.norm_inf(ca.vec(k_all)) <= _NO_CORRECTION, damping <= _SMALLEST_DAMPING)
    after = [*best[:3], cost, count + (best[2] < cost), next_damping, done]
    iterate = ca.Function("iterate", [u, x, cost, before, count, damping, p, data, x_0], after)

    zero = corrected(p, data, x_0, u, ca.MX(n_x, N + 1), ca.MX(n_u, N), ca.MX(n_u, n_x * N), 0)
    return repeated(iterate, iterations), ca.Function("roll", [p, data, x_0, u], list(zero[1:]))


def _corrected(stages: Stages, N: int, arguments: Any) -> ca.Function:
    """A trajectory with corrected inputs: inputs, states and cost."""
    p, data, x_0, u, x, k, K, alpha = arguments
    move = _move(stages)
    repeated = ca.repmat(p, 1, N), data[:, :N], u, x[:, :N], k, K, ca.repmat(alpha, 1, N)
    states, applied, costs = move.mapaccum("moves", N)(x_0, *repeated)
    n_x, n_u = size(stages.state), size(stages.input)
    end = states[:, N - 1]
    _, _, last = move(end, p, data[:, N], ca.MX(n_u, 1), end, ca.MX(n_u, 1), ca.MX(n_u, n_x), 0)
    return ca.Function("corrected", list(arguments), [applied, ca.horzcat(x_0, states), ca.sum2(costs) + last])


def _gains(  # noqa: PLR0913 - everything the sweep needs
    stages: Stages, N: int, p: Any, data: Any, u: Any, x: Any, damping: Any
) -> tuple[Any, Any]:
    """The corrections k (n_u, N) and K (n_u, n_x N) of the backward sweep."""
    n_x, n_u = size(stages.state), size(stages.input)
    quadratic = _quadratic(stages)
    inputs = ca.horzcat(u, ca.MX(n_u, 1))
    parts = quadratic.map(N + 1)(ca.repmat(p, 1, N + 1), data, x, inputs)
    V_x, V_xx = parts[0][:, -1], parts[1][:, n_x * N :]
    backwards = [_reversed(part, N, part.shape[1] // (N + 1)) for part in parts]
    sweep = _sweep(stages).mapaccum("sweeps", N, 2)
    swept = sweep(V_x, V_xx, ca.repmat(p, 1, N), _reversed(u, N, 1), *backwards, ca.repmat(damping, 1, N))
    return _reversed(swept[2], N, 1), _reversed(swept[3], N, n_x)


def _reversed(matrix: Any, N: int, width: int) -> Any:
    """The first N blocks of `width` columns, last first."""
    return ca.horzcat(*reversed(ca.horzsplit(matrix[:, : N * width], width)))


def _records(stages: Stages) -> tuple[Any, ...]:
    kinds = {"p": stages.constants, "data": stages.stage, "x": stages.state, "u": stages.input}
    return tuple(symbols(kind, {}, name=name) for name, kind in kinds.items())


def _move(stages: Stages) -> ca.Function:
    """One stage of a corrected trajectory: next state, input, cost of the stage."""
    (p, constants), (data, stage), (x, state), (u, _) = _records(stages)
    n_x, n_u = x.numel(), u.numel()
    x_old, k, K, alpha = ca.SX.sym("x_old", n_x), ca.SX.sym("k", n_u), ca.SX.sym("K", n_u, n_x), ca.SX.sym("alpha")
    lower, upper = (column_of(b) for b in stages.bounds(constants))
    applied = ca.fmin(ca.fmax(u + alpha * k + K @ (x - x_old), lower), upper)
    control = unpack(stages.input, applied)
    r = ca.vertcat(*stages.residual(constants, stage, state, control))
    after = column_of(stages.step(constants, state, control))
    results: Any = ca.cse([after, applied, ca.sumsqr(r)])
    return ca.Function("move", [x, p, data, u, x_old, k, K, alpha], results)


def _quadratic(stages: Stages) -> ca.Function:
    """Gradient and Gauss-Newton Hessian of a stage's cost, and the linearised step."""
    (p, constants), (data, stage), (x, state), (u, control) = _records(stages)
    r = ca.vertcat(*stages.residual(constants, stage, state, control))
    r_x, r_u = ca.jacobian(r, x), ca.jacobian(r, u)
    after = column_of(stages.step(constants, state, control))
    parts = [
        2 * r_x.T @ r,
        2 * r_x.T @ r_x,
        2 * r_u.T @ r,
        2 * r_u.T @ r_u,
        2 * r_u.T @ r_x,
        ca.jacobian(after, x),
        ca.jacobian(after, u),
    ]
    shared: Any = ca.cse([ca.densify(part) for part in parts])
    return ca.Function("quadratic", [p, data, x, u], shared)


def _sweep(stages: Stages) -> ca.Function:
    """One stage of the backward sweep: the value function before it, and the correction of its input."""
    (p, constants), _, (x, _), (u, _) = _records(stages)
    n_x, n_u = x.numel(), u.numel()
    l_x, l_xx, l_u, l_uu, l_ux, A, B, V_x, V_xx = (
        ca.SX.sym(name, *shape)
        for name, shape in (
            ("l_x", (n_x, 1)),
            ("l_xx", (n_x, n_x)),
            ("l_u", (n_u, 1)),
            ("l_uu", (n_u, n_u)),
            ("l_ux", (n_u, n_x)),
            ("A", (n_x, n_x)),
            ("B", (n_x, n_u)),
            ("V_x", (n_x, 1)),
            ("V_xx", (n_x, n_x)),
        )
    )
    damping = ca.SX.sym("damping")
    lower, upper = (column_of(b) for b in stages.bounds(constants))
    Q_x, Q_u = l_x + A.T @ V_x, l_u + B.T @ V_x
    Q_xx, Q_ux = l_xx + A.T @ V_xx @ A, l_ux + B.T @ V_xx @ A
    Q_uu = l_uu + B.T @ V_xx @ B + damping * ca.SX.eye(n_u)
    k, K = _clamped(Q_uu, Q_u, Q_ux, lower - u, upper - u)
    after_x = Q_x + K.T @ Q_uu @ k + K.T @ Q_u + Q_ux.T @ k
    after_xx = Q_xx + K.T @ Q_uu @ K + K.T @ Q_ux + Q_ux.T @ K
    after_xx = (after_xx + after_xx.T) / 2
    inputs = [V_x, V_xx, p, u, l_x, l_xx, l_u, l_uu, l_ux, A, B, damping]
    results: Any = ca.cse([after_x, after_xx, k, K])
    return ca.Function("sweep", inputs, results)


def _clamped(Q_uu: Any, Q_u: Any, Q_ux: Any, low: Any, high: Any) -> tuple[Any, Any]:
    """Minimise the quadratic in the inputs, clamping one after the other to the bounds it would leave."""
    n = Q_u.numel()
    free = ca.SX.ones(n)
    fixed = ca.SX.zeros(n)
    for _ in range(n):
        k = _solve(Q_uu, Q_u, free, fixed)
        out = ca.logic_or(k < low, k > high)
        held = ca.fmin(ca.fmax(k, low), high)
        fixed = ca.if_else(ca.logic_and(free > 0, out), held, fixed)
        free = free * (1 - out)
    k = _solve(Q_uu, Q_u, free, fixed)
    K = ca.horzcat(*(_solve(Q_uu, Q_ux[:, j], free, ca.SX.zeros(n)) for j in range(Q_ux.shape[1])))
    return k, K


def _solve(Q: Any, q: Any, free: Any, fixed: Any) -> Any:
    """Solve Q k = -q in the free inputs, the others at `fixed`."""
    masked = Q * (free @ free.T) + ca.diag(1 - free)
    right = (-q - Q @ fixed) * free
    return ca.solve(masked, right, "symbolicqr") * free + fixed if Q.shape[0] > 2 else _solve_two(masked, right) + fixed  # noqa: PLR2004


def _solve_two(Q: Any, right: Any) -> Any:
    determinant = Q[0, 0] * Q[1, 1] - Q[0, 1] * Q[1, 0]
    return ca.vertcat(Q[1, 1] * right[0] - Q[0, 1] * right[1], Q[0, 0] * right[1] - Q[1, 0] * right[0]) / determinant
