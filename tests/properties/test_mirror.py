"""Left and right are alike: a mirrored road gives mirrored motion, path, corridor and cost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from components import BLOCKS
from components.controller.corridor import Road, corridor
from components.controller.dubins import LaneChange, double_lane_change
from components.controller.mpc import Mpc
from components.controller.problems.ocp import Horizon
from components.controller.solving import PredictiveOutputs
from components.interfaces.buses import SLOTS, Actuation, ObstacleList, VehicleState
from components.interfaces.record import pack, unpack
from components.interfaces.sockets import ControllerInputs, PlantInputs
from fmus.lowering import lower
from tests.components.parameter_sets import block_values

SIDEWAYS = {"y", "psi", "v_y", "r"}
states = st.builds(
    VehicleState,
    x=st.floats(0, 100),
    y=st.floats(-4, 4),
    psi=st.floats(-0.6, 0.6),
    v_x=st.floats(3, 20),
    v_y=st.floats(-2, 2),
    r=st.floats(-1, 1),
)
slots = arrays(float, SLOTS, elements=st.floats(-5, 5))
traffic = st.builds(
    ObstacleList,
    valid=arrays(float, SLOTS, elements=st.sampled_from([0.0, 1.0])),
    id=st.just(np.arange(1.0, SLOTS + 1)),
    x=arrays(float, SLOTS, elements=st.floats(-20, 120)),
    y=slots,
    psi=arrays(float, SLOTS, elements=st.floats(-3, 3)),
    v=arrays(float, SLOTS, elements=st.floats(0, 15)),
    length=arrays(float, SLOTS, elements=st.floats(1, 12)),
    width=arrays(float, SLOTS, elements=st.floats(0.5, 2.5)),
)


def mirrored(record):
    """The same on the other side of the x axis."""
    turned = {n: -getattr(record, n) if n in SIDEWAYS else getattr(record, n) for n in record.__dataclass_fields__}
    return type(record)(**turned)


def block(name, **changes):
    return BLOCKS[name](**{**block_values(name), **changes})


BICYCLE, LEFT = block("bicycle"), block("mpc")
RIGHT = block("mpc", y_adjacent=-3.5, y_left=1.75, y_right=-5.25, b_1=LEFT.b_2, b_2=LEFT.b_1)


@given(state=states, delta_f=st.floats(-0.78, 0.78), T_r=st.floats(-160, 200))
def test_the_bicycle_turns_right_as_it_turns_left(state, delta_f, T_r):
    slope = BICYCLE.derivative(state, PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r)))
    other = BICYCLE.derivative(mirrored(state), PlantInputs(actuation=Actuation(delta_f=-delta_f, T_r=T_r)))
    assert pack(other).tolist() == pack(mirrored(slope)).tolist()


@given(w=st.floats(0.2, 8), R=st.floats(5, 80), l_d=st.floats(0, 20), x=st.floats(-10, 200), y=st.floats(-9, 9))
def test_a_path_to_the_right_mirrors_the_path_to_the_left(w, R, l_d, x, y):
    def path(side: float):
        return double_lane_change(
            LaneChange(w=side * w, R=R, l_d=l_d),
            x_0=0.0,
            x_1=20.0,
            x_8=90.0,
            x_14=190.0,
            y_lane=side * 0.5,
            corner=(40.0, side * 1.25),
        )

    left, right = path(1.0), path(-1.0)
    assert right.waypoints.x.tolist() == left.waypoints.x.tolist()
    assert right.waypoints.y == pytest.approx(-left.waypoints.y, abs=1e-12)
    s = left.project(x, y)
    assert right.project(x, -y) == pytest.approx(s, abs=1e-9)
    assert right.point(s)[1] == pytest.approx(-left.point(s)[1], abs=1e-12)


@given(obstacles=traffic, x=st.floats(-20, 120), t=st.floats(0, 3))
def test_the_corridor_mirrors_with_road_and_traffic(obstacles, x, t):
    assume((obstacles.y != 1.75).all())  # on the very middle of the road an obstacle counts as on the right
    upper, lower_edge = corridor(Road(y_left=5.25, y_right=-1.75, l_gap=0.35, l_ramp=6.0), obstacles, x, t)
    other = corridor(Road(y_left=1.75, y_right=-5.25, l_gap=0.35, l_ramp=6.0), mirrored(obstacles), x, t)
    assert other == pytest.approx((-lower_edge, -upper), abs=1e-12)


@given(state=states, z=arrays(float, 6, elements=st.floats(-0.7, 0.7)), y_d=st.floats(-1, 4))
def test_the_cost_mirrors_with_state_path_and_boundaries(state, z, y_d):
    x_d, ones = state.x + 2.5 * np.arange(1, 4), np.ones(3)
    horizon = Horizon(x_d=x_d, y_d=y_d * ones, y_upper=5.25 * ones, y_lower=-1.75 * ones)
    turned = Horizon(x_d=x_d, y_d=-y_d * ones, y_upper=1.75 * ones, y_lower=-5.25 * ones)
    cost = LEFT.problem(state, horizon).cost(z)
    flipped = np.concatenate([-z[:3], z[3:]])
    assert RIGHT.problem(mirrored(state), turned).cost(flipped) == pytest.approx(cost, rel=1e-12)


@given(state=states, obstacles=traffic)
def test_the_whole_controller_mirrors_with_the_road(state, obstacles):
    assume((obstacles.y != 1.75).all())

    def sampled(controller, u):
        column = lower(Mpc).output(pack(controller.start()), pack(u), pack(controller))
        return unpack(PredictiveOutputs, np.asarray(column).ravel(), Mpc.dimensions())

    left = sampled(LEFT, ControllerInputs(ego=state, obstacles=obstacles))
    right = sampled(RIGHT, ControllerInputs(ego=mirrored(state), obstacles=mirrored(obstacles)))
    assert right.path.x == pytest.approx(left.path.x, abs=1e-9)
    assert right.path.y == pytest.approx(-left.path.y, abs=1e-9)
    assert right.plan.x_d == pytest.approx(left.plan.x_d, abs=1e-9)
    assert right.plan.y_upper == pytest.approx(-left.plan.y_lower, abs=1e-9)
    if left.solver.kkt <= 1e-6:
        assert right.actuation.delta_f == pytest.approx(-left.actuation.delta_f, abs=1e-5)
        assert right.actuation.T_r == pytest.approx(left.actuation.T_r, abs=1e-2)
