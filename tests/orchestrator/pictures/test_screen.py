"""What stands where on the screen, for one run and for several."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.pictures import plots, screen
from orchestrator.pictures.run_picture import MICROSECONDS, RunPicture
from orchestrator.pictures.signals import signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare

STATIC = prepare("static", Options(mode="blocks"))


def _views(part):
    """All views of a group, with what it says of them."""
    return [view for one in part.parts for view in _views(one)] if isinstance(part, screen.ViewGroup) else [part]


def _titles(part):
    return [view.title for view in _views(part)]


def _named(part, title):
    """The view of a title."""
    (found,) = (view for view in _views(part) if view.title == title)
    return found


def _heads(run):
    """The titles of the columns of a run's tab: those of the questions, and what stands beside them."""
    seen, beside = run.parts
    heads = [*seen.parts[-1].parts, beside]
    assert [head.kind for head in heads] == ["tabs"] * len(heads), "the viewer shows no other titles of columns"
    return [column.title for head in heads for column in head.parts]


def test_a_run_is_answered_question_by_question():
    run, signals, about = screen.screen([RunPicture(STATIC.system, STATIC.scene)]).parts
    assert _titles(run) == [
        "Bird's eye view: x to the right, y up",
        "Following view",
        "Friction ≤ 1",
        "delta_f [rad]",
        "T_r [N.m]",
        "y [m]",
        "r [rad/s]",
        "a_x [m/s2]",
        "a_y [m/s2]",
        "mu_f [1]",
        "mu_r [1]",
        "path error [m]",
        "v_x [m/s]",
        "gap [m]",
        "Modes and solver status",
        "Values at the time cursor",
        "Events",
    ]
    assert _heads(run) == [*plots.QUESTIONS, "When was what?"]
    assert (signals.title, about.title) == ("All signals", "About this run")


@pytest.mark.parametrize("unit", ["controller", "traffic"])
def test_without_the_vehicles_place_the_eye_stays_over_the_road(unit):
    recorded = [name for signal in signals(STATIC.system) if signal.path.startswith(unit) for name in signal.columns]
    there = RunPicture(STATIC.system, STATIC.scene, "a", 0)
    nowhere = RunPicture(STATIC.system, STATIC.scene, "b", 1, recorded=[recorded])
    for runs, origin in (([nowhere], "/world"), ([nowhere, there], "/world/a/follow")):
        views = [view for view in _views(screen.screen(runs)) if isinstance(view, screen.Scenery)]
        assert [view.origin for view in views] == [origin, origin]


def test_limits_are_drawn_with_what_they_limit():
    run = screen.screen([RunPicture(STATIC.system, STATIC.scene)]).parts[0]
    torque = _named(run, "T_r [N.m]")
    assert set(torque.contents) == {
        "/signals/controller/actuation/T_r",
        "/limits/controller/actuation/T_r/upper",
        "/limits/controller/actuation/T_r/lower",
    }
    speed = _named(run, "v_x [m/s]")
    assert "/limits/plant/state/v_x/upper" in speed.contents
    friction = _named(run, "mu_f [1]")
    assert [part for part in friction.contents if part.startswith("/limits")] == ["/limits/plant/tyre/mu_f/upper"]


def test_several_runs_share_their_views_one_signal_each():
    runs = [RunPicture(STATIC.system, STATIC.scene, name, i, timed=False) for i, name in enumerate("ab")]
    extra = screen.Series("difference", ["/difference/b/x"])
    made = screen.screen(runs, [extra]).parts[0]
    assert made.title == "Runs: a blue, b orange"
    assert extra in _views(made)
    assert not any("Wall time" in title for title in _titles(made))
    yaw = _named(made, "r [rad/s]")
    assert yaw.contents == ["/signals/a/plant/state/r", "/signals/b/plant/state/r"]
    assert not any(view.legend for view in _views(made) if isinstance(view, screen.Series)), "the title says it"
    birds_eye = _views(made)[0]
    assert birds_eye.origin == "/world/a/follow"
    assert birds_eye.trails == ["/world/a/trail", "/world/b/trail"]


@pytest.mark.parametrize("scene", [None, STATIC.scene])
def test_empty_plugs_have_a_screen(scene):
    idle = prepare("idle", Options(mode="blocks"))
    titles = _titles(screen.screen([RunPicture(idle.system, scene)]))
    assert ("Following view" in titles) == (scene is not None)
    assert "path error [m]" not in titles


def _recorded(*groups):
    """The screen of a run that records signals, each group of them at its own ticks."""
    elements = [[c for s in signals(STATIC.system) if s.path.startswith(group) for c in s.columns] for group in groups]
    return screen.screen([RunPicture(STATIC.system, STATIC.scene, recorded=elements)])


def test_what_is_not_recorded_has_no_view():
    run, everything, _ = _recorded(("plant.",)).parts
    assert _titles(run) == [
        "Bird's eye view: x to the right, y up",
        "Following view",
        "Friction ≤ 1",
        "y [m]",
        "r [rad/s]",
        "a_x [m/s2]",
        "a_y [m/s2]",
        "mu_f [1]",
        "mu_r [1]",
        "v_x [m/s]",
        "Values at the time cursor",
        "Events",
    ]
    assert _heads(run) == [*plots.QUESTIONS, "When was what?"]
    *plotted, wall_time = _titles(everything)
    assert all(title.startswith("plant.") for title in plotted)
    assert wall_time.startswith("Wall time")


def test_what_is_recorded_at_other_ticks_is_not_computed_with():
    together, apart = (
        _titles(_recorded(*groups).parts[0])
        for groups in ([("plant.state", "controller.path")], [("plant.state",), ("controller.path",)])
    )
    assert "path error [m]" in together
    assert "Modes and solver status" in together
    assert not {"path error [m]", "Modes and solver status"} & set(apart)


def test_a_run_that_records_little_has_a_screen():
    run, signals, about = _recorded(("traffic.obstacles",)).parts
    assert _titles(run) == ["Bird's eye view: x to the right, y up", "Following view"]
    signals, about = _recorded(("controller.solver.iterations",)).parts
    assert _titles(signals) == ["controller.solver.iterations [1]", f"Wall time [{MICROSECONDS}] per step"]
    (about,) = _recorded().parts
    assert about.title == "About this run"


def test_limits_that_differ_between_runs_are_all_drawn():
    weaker = prepare("static", Options(mode="blocks", settings=["controller.T_dmax=150", "controller.v_ref=8"]))
    runs = [
        RunPicture(made.system, made.scene, name, i) for i, (name, made) in enumerate([("a", STATIC), ("b", weaker)])
    ]
    torque = _named(screen.screen(runs).parts[0], "T_r [N.m]")
    assert [part for part in torque.contents if part.startswith("/limits") and part.endswith("upper")] == [
        f"/limits/{name}/controller/actuation/T_r/upper" for name in "ab"
    ]


def test_a_legend_stands_only_where_a_title_cannot_name_the_series():
    _, everything, _ = screen.screen([RunPicture(STATIC.system, STATIC.scene)]).parts
    legends = {view.title: view.legend for view in _views(everything)}
    assert legends["plant.state [m]: x blue, y orange"] is False
    assert legends["controller.path [m]"] is False, "30 series"
    assert [title for title, legend in legends.items() if legend] == [
        "plant.state [m/s]",
        "plant.tyre [rad]",
        "plant.tyre [N]",
        "plant.tyre [1]",
        "plant.motion [m/s2]",
        "controller.solver [1]",
    ]
    assert "plant.state.r [rad/s]" in legends, "the title names a single signal"


def test_from_above_x_is_to_the_right_and_y_up_and_who_follows_looks_ahead():
    above, behind = _views(screen.screen([RunPicture(STATIC.system, STATIC.scene)]))[:2]
    for view in (above, behind):
        eye, target, up = (np.array(v, dtype=float) for v in (view.eye, view.target, view.up))
        right = np.cross(target - eye, up)
        wanted = (1, 0, 0) if view is above else (0, -1, 0)
        np.testing.assert_allclose(right / np.linalg.norm(right), wanted, atol=1e-12)
        assert view.origin == "/world/follow"
    assert above.up == (0, 1, 0)
    assert (above.eye[2] > above.target[2], above.eye[:2]) == (True, above.target[:2])
    assert behind.eye[0] < 0 < behind.target[0], "behind the vehicle"
    assert above.trails == behind.trails == ["/world/trail"]
