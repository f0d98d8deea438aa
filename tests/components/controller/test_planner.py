"""When the planner changes lanes: the static scenario's numbers, moving traffic on paper, and whole episodes.

This shows `blockade.py`, too.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from components.controller.dubins import LaneChange, radius
from components.controller.lanes import Lanes
from components.controller.planner import BACK, BESIDE, KEEP, OUT, Manoeuvre, no_manoeuvre, plan
from components.interfaces.record import pack

STATIC = ({"x": 49.5, "y": 0.0}, {"x": 92.5, "y": 3.5}, {"x": 110.5, "y": 3.5})
V = 10.0


def length(w: float) -> float:
    """How far along the road a change by `w` across takes at 10 m/s."""
    return float(LaneChange(w=w, R=radius(10.0, 0.5, 9.81), l_d=4.0).length)


@pytest.fixture(scope="module")
def lanes(make) -> Lanes:
    mpc = make("mpc")
    own = {"y_third": mpc.y_adjacent, "l_change": length(3.5), "l_third": length(3.5)}
    names = [field.name for field in dataclasses.fields(Lanes) if field.name not in own]
    return Lanes(**own, **{name: getattr(mpc, name) for name in names})


@pytest.fixture(scope="module")
def drive(lanes, vehicle, obstacles):
    """The manoeuvres at the given places, for traffic as a function of time at 10 m/s."""

    def driven(
        places: np.ndarray, traffic: Callable[[float], tuple[dict[str, float], ...]], road: Lanes = lanes
    ) -> list[Manoeuvre]:
        now, found = no_manoeuvre(), []
        for x in places:
            now = plan(road, now, vehicle(x=x), obstacles(*traffic((x - places[0]) / V)))
            found.append(now)
        return found

    return driven


def phases(run: list[Manoeuvre]) -> list[int]:
    """The phases in the order they come, without repetitions."""
    found = [int(m.phase) for m in run]
    return [p for i, p in enumerate(found) if i == 0 or found[i - 1] != p]


def test_the_static_scenario_changes_at_20_m_and_returns_at_62_m(drive):
    first = drive(np.array([0.0]), lambda _: STATIC)[0]
    assert first.x_0 == 0.0
    assert first.x_1 == pytest.approx(20.000, abs=5e-4)
    assert first.x_8 == pytest.approx(62.005, abs=5e-4)
    assert (first.x_o, first.y_o) == pytest.approx((49.5 - 2.3 - 0.35, 0.9 + 0.35), rel=1e-12)
    assert (first.planned, first.phase) == (1.0, KEEP)


@pytest.mark.parametrize("start", [0.0, 0.3, 0.999])
def test_phases_advance_in_order_at_the_places_planned(drive, lanes, start):
    places = np.arange(start, 130.0, 1.0)
    run = drive(places, lambda _: STATIC)
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    for phase, due in ((OUT, 20.0), (BESIDE, 20 + lanes.l_change), (BACK, 62.005), (KEEP, 62.005 + lanes.l_change)):
        first = next(x for x, m in zip(places, run, strict=True) if m.phase == phase and x > 10)
        if phase == KEEP:
            first = next(x for x, m in zip(places, run, strict=True) if m.phase == KEEP and x > 62)
        assert due - 1e-3 <= first < due + 1.0


@pytest.mark.parametrize("start", [0.0, 0.3, 0.999])
def test_a_static_plan_stays_what_it_was_wherever_the_samples_fall(drive, start):
    for now in drive(np.arange(start, 130.0, 1.0), lambda _: STATIC):
        assert (now.x_0, now.x_1, now.x_8) == pytest.approx((start, 20.0, 62.005), abs=5e-4)


@pytest.mark.parametrize("v", [9.95, 10.0, 10.5, 30.0])
def test_an_obstacle_that_outruns_the_ego_never_blocks(drive, v):
    run = drive(np.arange(0.0, 200.0, 1.0), lambda t: ({"x": 15.0 + v * t, "y": 0.0, "v": v},))
    assert phases(run) == [KEEP]
    assert not any(m.planned for m in run)


@pytest.mark.parametrize(
    "obstacle",
    [
        {"x": 49.5, "y": 3.5},  # in the other lane
        {"x": 49.5, "y": 0.0, "valid": 0.0},  # an empty slot
        {"x": 200.0, "y": 0.0},  # out of sight
        {"x": -20.0, "y": 0.0},  # passed long ago
    ],
)
def test_what_is_not_in_the_way_does_not_block(drive, obstacle):
    assert drive(np.array([0.0]), lambda _: (obstacle,))[0].planned == 0.0


@given(v=st.floats(0, 8), gap=st.floats(70, 90))
def test_a_slow_obstacle_is_passed_at_the_times_worked_out_on_paper(drive, lanes, v, gap):
    first = drive(np.array([0.0]), lambda _: ({"x": gap, "y": 0.0, "v": v},))[0]
    if not first.planned:  # so slow to catch up that the change begins beyond the sight
        assert V * (gap - lanes.l_before) / (V - v) - lanes.l_change >= lanes.l_sight
        return
    complete, back = (first.x_1 + lanes.l_change) / V, first.x_8 / V
    assert gap + v * complete - V * complete == pytest.approx(lanes.l_before, abs=1e-6)
    assert V * back - (gap + v * back) == pytest.approx(lanes.l_after, abs=1e-6)


def test_the_plan_for_steady_traffic_does_not_move_while_it_is_carried_out(drive):
    run = drive(np.arange(0.3, 160.0, 1.0), lambda t: ({"x": 40.0 + 5.0 * t, "y": 0.0, "v": 5.0},))
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    for now in run:
        assert (now.x_1, now.x_8) == pytest.approx((run[0].x_1, run[0].x_8), abs=1e-9)


def test_an_oncoming_obstacle_is_met_at_the_sum_of_the_speeds(drive, lanes):
    first = drive(np.array([0.0]), lambda _: ({"x": 90.0, "y": 0.0, "v": 5.0, "psi": np.pi},))[0]
    assert first.x_8 == pytest.approx(V * (90.0 + lanes.l_after) / 15.0, rel=1e-12)


def test_obstacles_close_behind_each_other_are_passed_in_one_go(drive):
    for x in (49.5 + 1.0, 80.0, 49.5 + 59.0):  # up to two changes and the distances before and after
        run = drive(np.arange(0.0, 160.0, 1.0), lambda _, x=x: ({"x": x, "y": 0.0}, {"x": 49.5, "y": 0.0}))
        assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
        assert (run[0].x_1, run[0].x_8) == pytest.approx((20.0, x + 12.505), abs=1e-3)


def test_a_whole_column_of_obstacles_is_passed_in_one_go_in_whatever_slot_each_is(drive):
    column = [{"x": 49.5 + 20.0 * i, "y": 0.0} for i in (4, 0, 3, 1, 2)]
    run = drive(np.arange(0.0, 180.0, 1.0), lambda _: tuple(column))
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    assert run[60].x_8 == pytest.approx(49.5 + 80.0 + 12.505, abs=1e-3)


@pytest.mark.parametrize("apart", [60.0, 80.0, 150.0])
def test_obstacles_with_room_between_them_are_two_episodes(drive, lanes, apart):
    places = np.arange(0.3, 260.0, 1.0)
    run = drive(places, lambda _: ({"x": 49.5, "y": 0.0}, {"x": 49.5 + apart, "y": 0.0}))
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP, OUT, BESIDE, BACK, KEEP]
    before = [m for x, m in zip(places, run, strict=True) if x < 62.005 + lanes.l_change]
    assert {(round(m.x_1, 3), round(m.x_8, 3)) for m in before} == {(20.0, 62.005)}
    assert 20.0 + apart - 1e-3 <= run[-1].x_1 < 21.0 + apart  # at the first sample in the own lane, if that is later
    assert run[-1].x_8 == pytest.approx(62.005 + apart, abs=1e-3)
    assert run[-1].x_0 >= 62.005 + lanes.l_change  # the path starts anew behind the first episode


def test_a_change_that_has_begun_stays_when_the_obstacle_vanishes(drive):
    run = drive(np.arange(0.3, 130.0, 1.0), lambda t: STATIC if t < 2.2 else ())
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    assert {(round(m.x_1, 3), round(m.x_8, 3)) for m in run} == {(20.0, 62.005)}


def test_a_change_that_has_not_begun_is_dropped_when_the_obstacle_vanishes(drive):
    run = drive(np.arange(0.3, 130.0, 1.0), lambda t: STATIC if t < 1.5 else ())
    assert phases(run) == [KEEP]
    assert [run[i].planned for i in (0, 14, 15, -1)] == [1.0, 1.0, 0.0, 0.0]


def test_a_change_needed_at_once_begins_at_the_ego(drive):
    run = drive(np.arange(0.3, 130.0, 1.0), lambda t: ({"x": 70.0, "y": 0.0},) if t > 5 else ())
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    began = next(m for m in run if m.phase == OUT)
    assert began.x_1 == pytest.approx(51.3, abs=1e-9)
    assert began.x_0 == pytest.approx(0.3)


def test_the_return_waits_for_an_obstacle_that_appears_beside(drive):
    late = {"x": 75.0, "y": 0.0}
    run = drive(np.arange(0.3, 130.0, 1.0), lambda t: (STATIC[0], late) if t > 4 else STATIC)
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    assert run[-1].x_8 == pytest.approx(75.0 + 12.505, abs=1e-3)


def test_a_return_that_has_begun_is_finished_whatever_appears(drive, lanes):
    run = drive(np.arange(0.3, 200.0, 1.0), lambda t: (STATIC[0], {"x": 100.0, "y": 0.0}) if t > 6.5 else STATIC)
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP, OUT, BESIDE, BACK, KEEP]
    second = [m for m in run if m.phase == OUT][-1]
    assert second.x_1 == pytest.approx(np.ceil(62.005 + lanes.l_change), abs=1.0)  # late, and at the ego


def test_a_position_that_is_no_number_leaves_no_trace(lanes, vehicle, obstacles):
    lost = plan(lanes, no_manoeuvre(), vehicle(x=float("nan")), obstacles(*STATIC))
    found = plan(lanes, lost, vehicle(x=2.0), obstacles(*STATIC))
    assert (found.x_0, found.x_1, found.x_8) == pytest.approx((2.0, 20.0, 62.005), abs=5e-4)


def test_an_adjacent_lane_on_the_right_asks_for_the_obstacles_right_corner(lanes, vehicle, obstacles):
    mirrored = dataclasses.replace(lanes, y_adjacent=-3.5)
    assert plan(mirrored, no_manoeuvre(), vehicle(), obstacles(*STATIC)).y_o == pytest.approx(-1.25)


def sampled(drive, v, *others, until=12.0):
    """The manoeuvres of an ego at 10 m/s among others at constant speed `v`, with what time it was."""
    places = np.arange(0, V * until, 1.0)
    return drive(places, lambda t: tuple({**o, "x": o["x"] + o.get("v", v) * t, "v": o.get("v", v)} for o in others))


def test_a_change_is_not_begun_while_somebody_is_beside(drive):
    beside = {"x": 0.0, "y": 3.5, "v": V}
    found = sampled(drive, 0.0, {"x": 60.0, "y": 0.0}, beside, until=4.0)
    assert {m.phase for m in found} == {KEEP}
    assert {m.planned for m in found} == {0.0}


def test_a_change_that_is_not_possible_slows_the_ego_down_to_stop_behind(drive, lanes):
    beside = {"x": 0.0, "y": 3.5, "v": V}
    found = sampled(drive, 0.0, {"x": 60.0, "y": 0.0}, beside, until=4.0)
    for x, m in zip(np.arange(0, 40, 1.0), found, strict=True):
        expected = min(V, np.sqrt(2 * lanes.a_follow * max(60.0 - x - lanes.l_before, 0)))
        assert m.v_d == pytest.approx(expected)


def test_somebody_who_comes_from_behind_fast_enough_to_be_in_the_way_is_waited_for(drive, lanes):
    fast = {"x": -20.0, "y": 3.5, "v": 16.0}
    found = sampled(drive, 5.0, {"x": 40.0, "y": 0.0}, fast)
    began = next(i for i, m in enumerate(found) if m.phase == OUT)
    t = began / V
    third = lanes.l_change / 3 / V
    assert -20.0 + (16.0 - V) * (t + third) >= 8.0  # it has passed, and is clear when the ego is beside it
    alone = sampled(drive, 5.0, {"x": 40.0, "y": 0.0})
    assert began > next(i for i, m in enumerate(alone) if m.phase == OUT)


def test_the_return_waits_beside_while_the_own_lane_is_taken(drive):
    def traffic(t):
        merged = {"x": 2.0 + V * t, "y": 0.0, "v": V}  # appears beside the ego, and leaves again
        return ({"x": 49.5, "y": 0.0}, merged) if 4.0 < t < 8.0 else ({"x": 49.5, "y": 0.0},)

    found = drive(np.arange(0, 110, 1.0), traffic)
    assert {m.phase for m in found[63:80]} == {BESIDE}  # without it the return begins at 62 m
    assert found[81].phase == BACK


def test_a_task_asks_for_the_same_change_as_an_obstacle_at_its_place(lanes, vehicle, obstacles):
    asked = plan(dataclasses.replace(lanes, x_task=49.5), no_manoeuvre(), vehicle(), obstacles())
    blocked = plan(lanes, no_manoeuvre(), vehicle(), obstacles({"x": 49.5, "y": 0.0}))
    assert (asked.planned, asked.x_1, asked.x_8) == (blocked.planned, blocked.x_1, blocked.x_8)


def test_nobody_ahead_leaves_the_speed_alone(drive):
    assert {m.v_d for m in sampled(drive, 0.0, *STATIC)} == {V}


def across(lanes, m, x):
    """Where the path is across the road at `x`, as a share of the way to the adjacent lane; changes are straight."""
    out, back = np.clip((x - np.array([m.x_1, m.x_8])) / lanes.l_change, 0.0, 1.0)
    return m.planned * (out - back)


SLOW = st.floats(0, 6)


@settings(max_examples=60)
@given(
    passed=st.tuples(st.floats(45, 80), SLOW),
    beside=st.tuples(st.floats(60, 200), SLOW),
    ahead=st.tuples(st.floats(90, 220), SLOW),
    vanishes=st.floats(0, 40),
)
@example(passed=(50.0, 2.5), beside=(120.0, 2.5), ahead=(140.0, 2.5), vanishes=40.0)  # opened a finished return again
def test_the_path_under_the_ego_never_jumps_and_a_return_is_finished(drive, lanes, passed, beside, ahead, vanishes):
    def traffic(t):
        seen = (*passed, 0.0), (*ahead, 0.0), (*beside, 3.5)
        moved = tuple({"x": x + v * t, "y": y, "v": v} for x, v, y in seen)
        return moved if t < vanishes else moved[1:]

    places = np.arange(0.0, 200.0, 1.0)
    run = drive(places, traffic)
    for x, before, now in zip(places[1:], run[:-1], run[1:], strict=True):
        assert abs(across(lanes, now, x) - across(lanes, before, x)) <= 1.0 / lanes.l_change + 1e-9
        if before.phase == BACK:
            assert now.x_8 == before.x_8
            assert now.phase in {BACK, KEEP}


OTHER_SIDE, BEYOND = -3.5, 7.0
BOTH = pytest.mark.parametrize("y_third", [OTHER_SIDE, BEYOND])
TAKEN = {"x": 45.0, "y": 3.5}


@pytest.fixture(scope="module")
def three(lanes):
    """The road with a third lane."""
    return lambda y_third: dataclasses.replace(lanes, y_third=y_third, l_third=length(y_third))


@BOTH
def test_the_third_lane_is_left_alone_while_the_adjacent_one_is_free(drive, lanes, three, y_third):
    places = np.arange(0.3, 130.0, 1.0)
    run, other = (drive(places, lambda _: STATIC, road) for road in (three(y_third), lanes))
    assert [pack(m).tolist() for m in run] == [pack(m).tolist() for m in other]


def test_a_change_goes_to_the_third_lane_where_the_adjacent_one_is_taken(drive, lanes, three):
    places = np.arange(0.3, 130.0, 1.0)
    run = drive(places, lambda _: (STATIC[0], TAKEN), three(OTHER_SIDE))
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    assert {(m.third, round(m.x_1, 3), round(m.x_8, 3)) for m in run} == {(1.0, 20.0, 62.005)}
    assert {m.y_o for m in run} == {-0.9 - 0.35}  # the obstacle's right corner
    assert {m.planned for m in drive(places[:30], lambda _: (STATIC[0], TAKEN), lanes)} == {0.0}


def test_beyond_the_adjacent_lane_a_change_takes_longer(drive, three):
    road = three(BEYOND)
    assert road.l_third > 1.3 * road.l_change
    run = drive(np.arange(0.3, 160.0, 1.0), lambda _: ({"x": 69.5, "y": 0.0}, {"x": 69.5, "y": 3.5}), road)
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]
    assert {m.third for m in run} == {1.0}
    assert run[0].x_1 + road.l_third == pytest.approx(69.5 - road.l_before)


@pytest.mark.parametrize("x", [40.0, 104.0])
def test_the_lane_between_has_to_be_free_for_both_crossings(drive, three, x):
    """The own lane is blocked at 70 m: the ego would cross the adjacent one around 45 m, and again around 95 m."""
    blocked = {"x": 70.0, "y": 0.0}, {"x": 70.0, "y": 3.5}
    free = drive(np.arange(0.0, 20.0, 1.0), lambda _: blocked, three(BEYOND))
    taken = drive(np.arange(0.0, 20.0, 1.0), lambda _: (*blocked, {"x": x, "y": 3.5}), three(BEYOND))
    assert ({m.planned for m in free}, {m.planned for m in taken}) == ({1.0}, {0.0})


def test_a_return_waits_for_the_lane_between(drive, three):
    """Somebody drives beside the ego in the adjacent lane from 6 s to 12 s; without it the return begins at 82 m."""
    blocked = {"x": 70.0, "y": 0.0}, {"x": 70.0, "y": 3.5}

    def traffic(t):
        return (*blocked, {"x": 2.0 + V * t, "y": 3.5, "v": V}) if 6 < t < 12 else blocked

    found = drive(np.arange(0, 150, 1.0), traffic, three(BEYOND))
    assert {m.phase for m in found[83:119]} == {BESIDE}
    assert found[121].phase == BACK


@BOTH
def test_what_blocks_both_other_lanes_is_followed(drive, three, y_third):
    everywhere = STATIC[0], TAKEN, {"x": 45.0, "y": y_third}
    run = drive(np.arange(0.0, 30.0, 1.0), lambda _: everywhere, three(y_third))
    assert {m.planned for m in run} == {0.0}
    assert run[-1].v_d < V


@pytest.mark.parametrize("when", [1.0, 2.5])
def test_a_change_keeps_its_lane_when_the_adjacent_one_becomes_free(drive, three, when):
    """Before it begins, at 2 s, and afterwards."""
    run = drive(np.arange(0.3, 130.0, 1.0), lambda t: (STATIC[0], TAKEN) if t < when else STATIC[:1], three(OTHER_SIDE))
    assert {m.third for m in run} == {1.0}
    assert phases(run) == [KEEP, OUT, BESIDE, BACK, KEEP]


def test_a_change_that_has_not_begun_takes_another_lane_when_its_own_is_taken(drive, three):
    there = {"x": 45.0, "y": OTHER_SIDE}
    run = drive(np.arange(0.3, 130.0, 1.0), lambda t: (STATIC[0], TAKEN if t < 1 else there), three(OTHER_SIDE))
    assert [run[i].third for i in (0, 9, 10, -1)] == [1.0, 1.0, 0.0, 0.0]
    late = drive(np.arange(0.3, 60.0, 1.0), lambda t: (STATIC[0], TAKEN if t < 2.5 else there), three(OTHER_SIDE))
    assert {m.third for m in late} == {1.0}  # it has begun


def test_the_third_lane_is_used_once_and_the_adjacent_one_the_next_time(drive, three):
    obstacles_ = STATIC[0], TAKEN, {"x": 160.0, "y": 0.0}, {"x": 160.0, "y": OTHER_SIDE}
    run = drive(np.arange(0.3, 220.0, 1.0), lambda _: obstacles_, three(OTHER_SIDE))
    assert phases(run) == [KEEP, OUT, BESIDE, BACK] * 2 + [KEEP]
    assert [m.third for m in run if m.phase == OUT] == sorted([m.third for m in run if m.phase == OUT], reverse=True)
    assert run[-1].third == 0.0
    assert run[-1].x_0 >= 79.0  # the path starts anew


@settings(max_examples=25)
@given(
    y_third=st.sampled_from([OTHER_SIDE, BEYOND]),
    seen=st.lists(st.tuples(st.floats(45, 220), SLOW, st.integers(0, 2)), min_size=2, max_size=6),
    vanishes=st.floats(0, 40),
)
def test_with_three_lanes_the_path_never_jumps_and_a_change_keeps_its_lane(drive, three, y_third, seen, vanishes):
    road = three(y_third)

    def traffic(t):
        moved = tuple({"x": x + v * t, "y": (0.0, 3.5, y_third)[lane], "v": v} for x, v, lane in seen)
        return moved if t < vanishes else moved[1:]

    def share(m, x):
        return across(dataclasses.replace(road, l_change=road.l_third if m.third else road.l_change), m, x)

    places = np.arange(0.0, 200.0, 2.0)
    run = drive(places, traffic, road)
    for x, before, now in zip(places[1:], run[:-1], run[1:], strict=True):
        assert abs(share(now, x) - share(before, x)) <= 2.0 / road.l_change + 1e-9
        if before.phase != KEEP:
            assert now.third == before.third
        if before.phase == BACK:
            assert now.x_8 == before.x_8
            assert now.phase in {BACK, KEEP}
