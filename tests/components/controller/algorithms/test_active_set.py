"""The bounded Newton method on problems with known solutions, and on the real problem against scipy."""

from __future__ import annotations

from itertools import product
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize

from components.controller.algorithms.active_set import minimise
from components.controller.algorithms.bounded import Solution
from components.controller.mpc import NEWTON_ITERATIONS
from components.controller.problems.ocp import Horizon, OptimalControlProblem
from components.controller.solving import KKT_TOLERANCE, N_P
from components.interfaces.maths import Array
from components.interfaces.quantity import quantity
from components.interfaces.record import pack, record, size
from components.interfaces.staging import symbols

N = 4


@record
class Quadratic:
    """Half z'Az + b'z between bounds, with A = BB' + share I."""

    B: Array = quantity("1", "factor of the matrix", shape=(N * N,))
    share: float = quantity("1", "least curvature")
    b: Array = quantity("1", "slope at zero", shape=(N,))
    lower: Array = quantity("1", "lower bounds", shape=(N,))
    upper: Array = quantity("1", "upper bounds", shape=(N,))

    def cost(self, z: Array) -> float:
        total = 0.0
        for j in range(N):
            along = sum(self.B[N * i + j] * z[i] for i in range(N))
            total = total + along * along / 2 + self.b[j] * z[j] + self.share * z[j] * z[j] / 2
        return total

    def bounds(self) -> tuple[Array, Array]:
        return self.lower, self.upper


def solved(problem: Quadratic, z: Array, iterations: int = 30) -> Solution:
    return minimise(problem, {}, z, iterations=iterations, tolerance=1e-6)


def separable(curvatures: Any, slopes: Any, width: float = 1.0) -> Quadratic:
    ones = np.ones(N)
    factor = np.diag(np.sqrt(np.asarray(curvatures, dtype=float))).ravel()
    return Quadratic(B=factor, share=0.0, b=np.asarray(slopes, dtype=float), lower=-width * ones, upper=width * ones)


def test_a_separable_problem_ends_at_the_clipped_minimum_of_each_variable():
    found = solved(separable([1.0, 2.0, 4.0, 1.0], [0.5, -1.0, 8.0, -3.0]), np.zeros(N))
    assert found.z == pytest.approx([-0.5, 0.5, -1.0, 1.0], abs=1e-9)  # two inside, one on each bound
    assert found.cost == pytest.approx(-0.125 - 0.25 + (2 - 8) + (0.5 - 3), rel=1e-9)
    assert found.kkt < 1e-9


def test_without_an_active_bound_one_newton_step_is_enough():
    found = solved(separable([1.0, 2.0, 4.0, 8.0], [0.1, 0.1, 0.1, 0.1]), np.full(N, 0.9))
    assert found.z == pytest.approx([-0.1, -0.05, -0.025, -0.0125], rel=1e-9)
    assert found.iterations == 1.0


def test_at_the_optimum_nothing_moves_and_no_iteration_counts():
    problem = separable([1.0, 2.0, 4.0, 1.0], [0.5, -1.0, 8.0, -3.0])
    optimum = np.array([-0.5, 0.5, -1.0, 1.0])
    found = solved(problem, optimum)
    assert found.z.tolist() == optimum.tolist()
    assert found.kkt == pytest.approx(0.0, abs=1e-15)
    assert found.iterations == 0.0


def test_a_start_outside_the_bounds_is_brought_back():
    found = solved(separable([1.0] * N, [0.0, 0.0, -5.0, 5.0]), np.array([7.0, -7.0, 7.0, -7.0]))
    assert found.z == pytest.approx([0.0, 0.0, 1.0, -1.0], abs=1e-9)


def test_a_problem_without_numbers_keeps_its_start_and_says_so():
    found = solved(separable([1.0] * N, [float("nan"), 0.0, 0.0, 0.0]), np.full(N, 0.25))
    assert found.z.tolist() == [0.25] * N
    assert np.isnan(found.cost)


entries = st.floats(-2, 2)
quadratics = st.builds(
    Quadratic,
    B=arrays(float, N * N, elements=entries),
    share=st.floats(0.05, 1),
    b=arrays(float, N, elements=st.floats(-5, 5)),
    lower=arrays(float, N, elements=st.floats(-2, -0.1)),
    upper=arrays(float, N, elements=st.floats(0.1, 2)),
)


def minimum(A: Array, problem: Quadratic) -> Array:
    """The minimiser, by trying every way in which variables can sit on their bounds."""
    best, least = np.zeros(N), np.inf
    for sides in product((-1, 0, 1), repeat=N):
        side = np.array(sides)
        free = side == 0
        z = np.where(side < 0, problem.lower, problem.upper)
        if free.any():
            z[free] = np.linalg.solve(A[np.ix_(free, free)], -problem.b[free] - A[np.ix_(free, ~free)] @ z[~free])
        value = z @ A @ z / 2 + problem.b @ z
        if value < least and np.all((problem.lower <= z) & (z <= problem.upper)):
            best, least = z, value
    return best


@settings(max_examples=50)
@given(problem=quadratics, share=arrays(float, N, elements=st.floats(0, 1)))
def test_convex_problems_end_at_the_best_of_all_combinations_of_active_bounds(problem, share):
    B = problem.B.reshape(N, N)
    A = B @ B.T + problem.share * np.eye(N)
    found = solved(problem, problem.lower + share * (problem.upper - problem.lower))
    assert np.all((problem.lower <= found.z) & (found.z <= problem.upper))
    assert found.kkt <= 1e-6
    assert found.z == pytest.approx(minimum(A, problem), abs=1e-5)
    assert found.cost == pytest.approx(found.z @ A @ found.z / 2 + problem.b @ found.z, rel=1e-9, abs=1e-12)


@record
class Valley:
    """Rosenbrock's valley of a given steepness, between bounds."""

    steep: float = quantity("1", "steepness")
    reach: float = quantity("1", "upper bound of both variables")

    def cost(self, z: Array) -> float:
        return (1 - z[0]) * (1 - z[0]) + self.steep * (z[1] - z[0] * z[0]) * (z[1] - z[0] * z[0])

    def bounds(self) -> tuple[Any, Any]:
        return ca.DM([-2, -2]), ca.vertcat(self.reach, self.reach)


@pytest.mark.parametrize(
    ("reach", "optimum"),
    [
        (2.0, (1.0, 1.0)),  # free
        (0.5, (0.5, 0.25)),  # z_0 on its bound
    ],
)
def test_a_curved_valley_is_followed_to_its_end(reach, optimum):
    found = minimise(Valley(steep=100.0, reach=reach), {}, np.array([-1.2, 0.4]), iterations=80, tolerance=1e-6)
    assert found.z == pytest.approx(optimum, abs=1e-6)
    assert found.kkt < 1e-6


def test_what_has_not_converged_ends_at_the_bound():
    found = minimise(Valley(steep=100.0, reach=2.0), {}, np.array([-1.2, 0.4]), iterations=3, tolerance=1e-6)
    assert found.iterations == 3.0
    assert found.kkt > 1e-6


def test_what_has_converged_makes_its_last_step_in_full():
    """Chosen by cost, the step would be any: costs this near to the minimum differ by rounding."""
    start = np.array([1.0 + 2e-8, 1.0 + 4e-8])
    found = minimise(Valley(steep=1.0, reach=2.0), {}, start, iterations=1, tolerance=1e-6)
    assert found.iterations == 0.0
    assert found.z == pytest.approx([1.0, 1.0], abs=1e-12)


@settings(max_examples=20)
@given(problem=quadratics)
def test_symbols_and_numbers_give_the_same_bits(problem):
    column, record_of_symbols = symbols(Quadratic, {}, ca.MX, "p")
    z = ca.MX.sym("z", N)
    graph = minimise(record_of_symbols, {}, z, iterations=6, tolerance=1e-6)
    lowered = ca.Function("solve", [column, z], [graph.z, graph.cost, graph.kkt, graph.iterations])
    start = np.full(N, 0.05)
    z_found, *rest = lowered(pack(problem), start)
    number = solved(problem, start, iterations=6)
    assert np.asarray(z_found).ravel().tolist() == number.z.tolist()
    assert [float(v) for v in rest] == [number.cost, number.kkt, number.iterations]


def random_problem(mpc: Any, vehicle: Any, rng: np.random.Generator) -> OptimalControlProblem:
    """A vehicle near a path with a bend, inside a corridor; all at random."""
    dt = mpc.dt
    ego = vehicle(
        x=0.0,
        y=rng.uniform(-0.4, 0.4),
        psi=rng.uniform(-0.2, 0.2),
        v_x=rng.uniform(9, 11),
        v_y=rng.uniform(-0.5, 0.5),
        r=rng.uniform(-0.4, 0.4),
    )
    s = 10 * dt * np.arange(1, N_P + 1)
    y_d = rng.uniform(-1, 1) * (s / s[-1]) ** 2
    edges = {"y_upper": y_d + rng.uniform(1.2, 5), "y_lower": y_d - rng.uniform(1.2, 5)}
    return mpc.problem(ego, Horizon(x_d=s, y_d=y_d, **edges))


@pytest.mark.parametrize("setting", [{}, {"dt": 0.1, "b_3": 1e-4}], ids=["tuned", "literal"])
def test_cold_starts_of_the_real_problem_reach_the_best_of_several_scipy_starts(make, vehicle, setting):
    mpc, rng = make("mpc", **setting), np.random.default_rng(1)
    data, problem = symbols(OptimalControlProblem, {"N_p": N_P}, ca.SX, "data")
    z = ca.SX.sym("z", 2 * N_P)
    J = problem.cost(z)
    value_and_slope = ca.Function("J", [z, data], [J, ca.gradient(J, z)])
    buffer, evaluate = value_and_slope.buffer()  # as plain memory: it is called tens of thousands of times
    arguments, results = (np.zeros(2 * N_P), np.zeros(data.numel())), (np.zeros(1), np.zeros(2 * N_P))
    for i in range(2):
        buffer.set_arg(i, memoryview(arguments[i]))
        buffer.set_res(i, memoryview(results[i]))
    reached, trials = 0, 100
    for _ in range(trials):
        problem = random_problem(mpc, vehicle, rng)
        column = pack(problem)
        lower, upper = problem.bounds()

        def objective(z: Array, column: Array = column) -> tuple[float, Array]:
            arguments[0][:], arguments[1][:] = z, column
            evaluate()
            return float(results[0][0]), results[1].copy()

        best = min(
            minimize(
                objective,
                rng.uniform(lower, upper),
                jac=True,
                bounds=list(zip(lower, upper, strict=True)),
                method="L-BFGS-B",
                options={"ftol": 1e-14, "gtol": 1e-9, "maxiter": 500},
            ).fun
            for _ in range(4)
        )
        start = rng.uniform(lower, upper) / 2
        found = minimise(
            problem,
            {"N_p": N_P},
            start,
            iterations=NEWTON_ITERATIONS,
            tolerance=KKT_TOLERANCE,
        )
        assert np.all((lower <= found.z) & (found.z <= upper))
        reached += found.cost <= best + 1e-6 * max(1.0, abs(best))
    assert reached >= 0.9 * trials, f"{reached} of {trials}"


def test_a_problem_packs_to_the_column_the_solver_reads():
    assert size(OptimalControlProblem, {"N_p": N_P}) == 7 + 4 + 4 * N_P + 6 + 6
