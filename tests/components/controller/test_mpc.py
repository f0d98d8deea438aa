"""The controller as a whole: equations and lowered function, convergence, bounds, and what it does when lost."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from components.controller.dubins import double_lane_change
from components.controller.mpc import Mpc, MpcState
from components.controller.planner import no_manoeuvre
from components.controller.solving import N_P, PredictiveOutputs
from components.interfaces.buses import SolverStatus
from components.interfaces.record import pack, unpack, variables
from components.interfaces.sockets import ControllerInputs, PlantInputs
from fmus.lowering import lower

STATIC = ({"x": 49.5, "y": 0.0}, {"x": 92.5, "y": 3.5}, {"x": 110.5, "y": 3.5})
DIMS = Mpc.dimensions()
TUNED, LITERAL = {}, {"dt": 0.1, "b_3": 1e-4}


@pytest.fixture(scope="module")
def mpc(make) -> Mpc:
    return make("mpc")


def lowered(block: Mpc, x: MpcState, u: ControllerInputs) -> tuple[MpcState, PredictiveOutputs]:
    """One sample by the function that also becomes C."""
    columns = lower(Mpc).step(pack(x), pack(u), pack(block), 0.1)
    x_next, y = (np.asarray(column).ravel() for column in columns)
    return unpack(MpcState, x_next, DIMS), unpack(PredictiveOutputs, y, DIMS)


def static_run(make: Any, obstacles: Any, setting: dict[str, float]) -> list[tuple[MpcState, ControllerInputs]]:
    """Controller states and inputs along the static scenario."""
    controller, plant = make("mpc", **setting), make("bicycle")
    x, c, seen = plant.start(), controller.start(), []
    for _ in range(113):
        u = ControllerInputs(ego=x, obstacles=obstacles(*STATIC))
        seen.append((c, u))
        c, y = lowered(controller, c, u)
        for _ in range(10):
            x = plant.step(x, PlantInputs(actuation=y.actuation), 0.01)
    return seen


@pytest.fixture(scope="module")
def runs(make, obstacles):
    return {name: static_run(make, obstacles, setting) for name, setting in (("t", TUNED), ("l", LITERAL))}


@pytest.mark.parametrize(("name", "setting"), [("t", TUNED), ("l", LITERAL)], ids=["tuned", "literal"])
def test_every_solve_of_the_static_scenario_converges_in_few_iterations(make, runs, name, setting):
    for x, u in runs[name]:
        solver = lowered(make("mpc", **setting), x, u)[1].solver
        assert solver.status == SolverStatus.converged
        assert solver.kkt <= 1e-6
        assert solver.iterations <= 8


def test_the_equations_with_numbers_equal_the_lowered_function(mpc, runs):
    for x, u in runs["t"][::8]:
        for number, symbol in zip(mpc.sample(x, u), lowered(mpc, x, u), strict=True):
            assert pack(number) == pytest.approx(pack(symbol), rel=1e-12, abs=1e-12)


def test_output_and_step_are_the_two_sides_of_one_sample(mpc, runs):
    x, u = runs["t"][25]
    x_next, y = mpc.sample(x, u)
    assert pack(mpc.output(x, u)).tolist() == pack(y).tolist()
    assert pack(mpc.step(x, u, 0.1)).tolist() == pack(x_next).tolist()


def test_p0_and_p1_stay_where_they_are_along_the_static_run(mpc, runs):
    for x, u in runs["t"]:
        path = lowered(mpc, x, u)[1].path
        assert (*path.x[:2], *path.y[:2]) == pytest.approx((0.0, 20.0, 0.0, 0.0), abs=5e-4)


@pytest.mark.parametrize(("name", "rms", "largest"), [("t", 0.21, 0.47), ("l", 0.04, 0.10)], ids=["tuned", "literal"])
def test_the_static_run_follows_its_path_as_closely_as_the_prototype(mpc, runs, name, rms, largest):
    places = {"x_0": 0.0, "x_1": 20.0, "x_8": 62.005, "x_14": 130.0, "y_lane": 0.0, "corner": (46.85, 1.25)}
    path = double_lane_change(mpc.shape(), **places)
    errors = []
    for _, u in runs[name]:
        x, y = path.point(path.project(u.ego.x, u.ego.y))
        errors.append(np.hypot(u.ego.x - x, u.ego.y - y))
    assert np.sqrt(np.mean(np.square(errors))) <= rms
    assert max(errors) <= largest


def test_the_first_decision_is_applied_and_the_plan_starts_with_it(mpc, runs):
    for x, u in runs["t"][::10]:
        x_next, y = lowered(mpc, x, u)
        assert y.actuation.delta_f == pytest.approx(mpc.delta_scale * x_next.z[0], rel=1e-15)
        assert y.actuation.T_r == pytest.approx(mpc.T_scale * x_next.z[N_P], rel=1e-15)


def test_the_desired_points_lie_the_reference_speed_ahead_on_the_path(mpc, vehicle, obstacles):
    y = mpc.sample(mpc.start(), ControllerInputs(ego=vehicle(y=0.3), obstacles=obstacles()))[1]
    assert y.plan.x_d == pytest.approx([2.5, 5.0, 7.5], rel=1e-12)
    assert y.plan.y_d == pytest.approx([0.0] * 3, abs=1e-12)
    assert (y.plan.y_upper.tolist(), y.plan.y_lower.tolist()) == ([5.25] * 3, [-1.75] * 3)


def test_on_an_empty_road_the_path_is_the_straight_lane_at_any_time(mpc, vehicle, obstacles):
    x = mpc.start()
    for place in (0.0, 40.0, 400.0):
        x, y = mpc.sample(x, ControllerInputs(ego=vehicle(x=place), obstacles=obstacles()))
        assert y.path.y == pytest.approx(np.zeros(15), abs=1e-12)
        assert np.all(np.diff(y.path.x) >= -1e-9)
        assert y.path.x[14] >= place + 7.5
        assert y.solver.status == SolverStatus.converged


def test_a_vehicle_left_of_its_path_steers_right_and_a_slow_one_drives(mpc, vehicle, obstacles):
    left = mpc.sample(mpc.start(), ControllerInputs(ego=vehicle(y=0.5), obstacles=obstacles()))[1]
    assert left.actuation.delta_f < -0.01
    slow = mpc.sample(mpc.start(), ControllerInputs(ego=vehicle(v_x=9.0), obstacles=obstacles()))[1]
    assert slow.actuation.T_r == 200.0
    fast = mpc.sample(mpc.start(), ControllerInputs(ego=vehicle(v_x=11.0), obstacles=obstacles()))[1]
    braked = -mpc.a_follow * mpc.m * mpc.R_w / 2  # as hard as the desired point slows down
    assert fast.actuation.T_r == pytest.approx(braked, rel=0.02)


@pytest.mark.parametrize("lost", ["x", "y", "psi", "v_x", "v_y", "r"])
def test_an_ego_that_is_no_number_is_met_by_the_shifted_previous_plan(mpc, vehicle, obstacles, lost):
    before = MpcState(manoeuvre=no_manoeuvre(), z=np.array([0.1, 0.2, 0.3, -0.4, 0.5, 0.6]))
    u = ControllerInputs(ego=vehicle(**{lost: float("nan")}), obstacles=obstacles(*STATIC))
    x, y = lowered(mpc, before, u)
    assert y.solver.status == SolverStatus.fallback
    assert x.z.tolist() == [0.2, 0.3, 0.3, 0.5, 0.6, 0.6]
    assert (y.actuation.delta_f, y.actuation.T_r) == (0.2, 100.0)
    for shown in (x, y.solver, y.path):
        assert np.isfinite(pack(shown)).all()
    # what it would predict from there it cannot know: it shows the path
    assert y.plan.x.tolist() == y.plan.x_d.tolist()
    assert y.plan.y.tolist() == y.plan.y_d.tolist()


def test_after_a_lost_sample_it_goes_on_as_if_nothing_had_been(mpc, vehicle, obstacles):
    lost = ControllerInputs(ego=vehicle(x=float("nan")), obstacles=obstacles(*STATIC))
    good = dataclasses.replace(lost, ego=vehicle(x=1.0))
    y = lowered(mpc, lowered(mpc, mpc.start(), lost)[0], good)[1]
    assert y.solver.status == SolverStatus.converged
    assert pack(y) == pytest.approx(pack(lowered(mpc, mpc.start(), good)[1]), abs=1e-5)


def test_a_previous_plan_outside_the_bounds_is_clipped(mpc, vehicle, obstacles):
    before = MpcState(manoeuvre=no_manoeuvre(), z=np.array([9.0, 9.0, -9.0, 9.0, -9.0, 9.0]))
    u = ControllerInputs(ego=vehicle(v_y=float("nan")), obstacles=obstacles())
    y = lowered(mpc, before, u)[1]
    assert (y.actuation.delta_f, y.actuation.T_r) == (mpc.delta_max, -160.0)


@given(
    ego=arrays(float, 6, elements=st.floats(-30, 30)),
    z=arrays(float, 2 * N_P, elements=st.floats(-3, 3)),
    places=arrays(float, 3, elements=st.floats(-50, 150)),
)
def test_decisions_stay_inside_their_bounds_whatever_the_state(mpc, vehicle, obstacles, ego, z, places):
    state = vehicle(**dict(zip(("x", "y", "psi", "v_x", "v_y", "r"), ego, strict=True)))
    u = ControllerInputs(ego=state, obstacles=obstacles(*({"x": x, "y": 0.0} for x in places)))
    x, y = lowered(mpc, MpcState(manoeuvre=no_manoeuvre(), z=z), u)
    assert abs(y.actuation.delta_f) <= mpc.delta_max
    assert -mpc.T_bmax <= y.actuation.T_r <= mpc.T_dmax
    assert np.all(np.abs(x.z[:N_P]) <= mpc.delta_max / mpc.delta_scale)
    assert np.all((x.z[N_P:] >= -mpc.T_bmax / mpc.T_scale) & (x.z[N_P:] <= mpc.T_dmax / mpc.T_scale))
    assert int(y.solver.status) in list(SolverStatus)
    assert np.isfinite(pack(y.solver)).all()


def test_the_horizon_of_the_block_is_the_papers(mpc):
    assert DIMS == {"N_p": 3}
    shapes = {v.name: v.shape for v in variables(PredictiveOutputs, DIMS)}
    assert shapes["plan.x"] == (3,)
    assert shapes["path.x"] == (15,)
    assert mpc.start().z.tolist() == [0.0] * 6
