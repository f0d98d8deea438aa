"""The two-level controller: what it plans from, what it tracks, and what it does when lost."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controller.problems.point_mass import PointMass
from components.controller.solving import PredictiveOutputs
from components.controller.tracking import Target, deviation
from components.controller.two_level_mp import TwoLevelMp, TwoLevelState
from components.interfaces.buses import SolverStatus
from components.interfaces.record import pack, unpack
from components.interfaces.sockets import ControllerInputs
from fmus.lowering import lower

STATIC = ({"x": 49.5, "y": 0.0}, {"x": 92.5, "y": 3.5}, {"x": 110.5, "y": 3.5})
DIMS = TwoLevelMp.dimensions()


@pytest.fixture(scope="module")
def block(make) -> TwoLevelMp:
    return make("two_level_mp")


def sampled(block, x, u) -> tuple[TwoLevelState, PredictiveOutputs]:
    """One sample by the function that also becomes C."""
    columns = lower(TwoLevelMp).step(pack(x), pack(u), pack(block), 0.1)
    x_next, y = (np.asarray(column).ravel() for column in columns)
    return unpack(TwoLevelState, x_next, DIMS), unpack(PredictiveOutputs, y, DIMS)


def begun(block, **point: float) -> TwoLevelState:
    """The state after some sample that left the planned point there."""
    where = PointMass(**{"x": 0.0, "y": 0.0, "v_x": 10.0, "v_y": 0.0, **point})
    return dataclasses.replace(block.start(), point=where, begun=1.0)


def test_straight_running_in_the_own_lane_needs_no_actuation(block, vehicle, obstacles):
    x, y = sampled(block, block.start(), ControllerInputs(ego=vehicle(x=2.0), obstacles=obstacles()))
    assert (y.actuation.delta_f, y.actuation.T_r) == pytest.approx((0.0, 0.0), abs=0.5)
    assert (x.point.x, x.point.y) == pytest.approx((3.0, 0.0), abs=1e-2)
    assert y.plan.x == pytest.approx([4.5, 7.0, 9.5], abs=1e-2)
    assert y.solver.status == SolverStatus.converged
    assert y.path.y.tolist() == [0.0] * 15


def test_the_first_plan_begins_at_the_vehicle(block, vehicle, obstacles):
    ego = vehicle(x=5.0, y=0.4, psi=0.1, v_y=0.2)
    x, _ = sampled(block, block.start(), ControllerInputs(ego=ego, obstacles=obstacles()))
    at = np.array([5.0, 0.4])
    velocity = np.array([10 * np.cos(0.1) - 0.2 * np.sin(0.1), 10 * np.sin(0.1) + 0.2 * np.cos(0.1)])
    a = (np.array([x.point.v_x, x.point.v_y]) - velocity) / 0.1
    assert np.array([x.point.x, x.point.y]) == pytest.approx(at + velocity * 0.1 + a * 0.005, abs=1e-12)
    assert np.abs(a).max() <= 4.905 * (1 + 1e-12)
    assert a[1] < -1  # back to the lane


def test_later_plans_go_on_from_the_planned_point_beside_the_vehicle(block, vehicle, obstacles):
    before = begun(block, x=9.3, y=0.2, v_x=9.8, v_y=1.0)
    ego = vehicle(x=10.0, y=-0.3, psi=0.1)
    x, y = sampled(block, before, ControllerInputs(ego=ego, obstacles=obstacles()))
    direction = np.array([9.8, 1.0]) / np.hypot(9.8, 1.0)
    point = np.array([9.3, 0.2])
    point = point + direction * (direction @ (np.array([10.0, -0.3]) - point))
    a = (np.array([x.point.v_x, x.point.v_y]) - [9.8, 1.0]) / 0.1
    moved = point + 0.1 * np.array([9.8, 1.0]) + 0.005 * a
    assert [x.point.x, x.point.y] == pytest.approx(moved, abs=1e-12)
    kappa = (9.8 * a[1] - 1.0 * a[0]) / np.hypot(9.8, 1.0) ** 3
    target = Target(x=point[0], y=point[1], psi=np.arctan2(1.0, 9.8), kappa=kappa)
    expected = block.steering(before.K, deviation(target, ego), kappa, 10.0)
    assert y.actuation.delta_f == pytest.approx(np.clip(expected, -block.delta_max, block.delta_max), rel=1e-9)


def test_the_speed_is_that_of_the_plan(block, vehicle, obstacles):
    ego = vehicle(v_x=9.9)
    x, y = sampled(block, begun(block, v_x=9.9), ControllerInputs(ego=ego, obstacles=obstacles()))
    wanted = block.K_p * (np.hypot(x.point.v_x, x.point.v_y) - 9.9)
    assert y.actuation.T_r == pytest.approx(np.clip(wanted, -160, 200), rel=1e-9)
    assert y.actuation.T_r > 10


def test_the_path_is_that_of_mpc(make, block, vehicle, obstacles):
    u = ControllerInputs(ego=vehicle(), obstacles=obstacles(*STATIC))
    mpc = make("mpc")
    found, expected = (b.sample(b.start(), u)[1] for b in (block, mpc))
    assert pack(found.path).tolist() == pack(expected.path).tolist()
    assert found.plan.y_upper.tolist() == expected.plan.y_upper.tolist()


@pytest.mark.parametrize("lost", ["x", "y", "psi", "v_x", "v_y", "r"])
@pytest.mark.parametrize("first", [True, False])
def test_a_lost_sample_is_forgotten(block, vehicle, obstacles, lost, first):
    seen = obstacles(*STATIC)
    x = block.start()
    if not first:
        x, _ = sampled(block, x, ControllerInputs(ego=vehicle(), obstacles=seen))
    x, y = sampled(block, x, ControllerInputs(ego=vehicle(**{lost: float("nan")}), obstacles=seen))
    assert np.isfinite(pack(x)).all()
    assert np.isfinite(pack(y.actuation)).all()
    x, y = sampled(block, x, ControllerInputs(ego=vehicle(x=1.0), obstacles=seen))
    assert np.isfinite(pack(x)).all()
    assert np.isfinite(pack(y)).all()
    assert y.solver.status == SolverStatus.converged
    assert (x.point.x, x.point.y) == pytest.approx((2.0, 0.0), abs=0.1)


@given(y=st.floats(-1, 1), psi=st.floats(-0.3, 0.3), r=st.floats(-0.5, 0.5), x=st.floats(0, 40), off=st.floats(-1, 1))
def test_left_and_right_are_alike(block, make, vehicle, obstacles, x, y, psi, r, off):
    right = RIGHT.setdefault("block", make("two_level_mp", y_adjacent=-3.5, y_left=1.75, y_right=-5.25))
    turned = [{**o, "y": -o["y"]} for o in STATIC]
    here, there = vehicle(x=x, y=y, psi=psi, r=r), vehicle(x=x, y=-y, psi=-psi, r=-r)
    a = sampled(block, begun(block, y=off, v_y=off), ControllerInputs(ego=here, obstacles=obstacles(*STATIC)))[1]
    b = sampled(right, begun(right, y=-off, v_y=-off), ControllerInputs(ego=there, obstacles=obstacles(*turned)))[1]
    if a.solver.kkt <= 1e-6:
        assert b.actuation.delta_f == pytest.approx(-a.actuation.delta_f, abs=1e-5)
        assert b.plan.y == pytest.approx(-a.plan.y, abs=1e-5)


RIGHT: dict[str, TwoLevelMp] = {}
