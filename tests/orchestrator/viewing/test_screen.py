"""What stands where on the screen, for one run and for several."""

from __future__ import annotations

import pytest

from orchestrator.scenario import Options, prepare
from orchestrator.viewing import screen
from orchestrator.viewing.run_picture import MICROSECONDS, RunPicture

STATIC = prepare("static", Options(mode="blocks"))


def _views(part):
    """All views of a group, with what it says of them."""
    return [view for one in part.parts for view in _views(one)] if isinstance(part, screen.Group) else [part]


def _titles(part):
    return [view.title for view in _views(part)]


def test_a_run_is_answered_question_by_question():
    run, signals, about = screen.screen([RunPicture(STATIC.system, STATIC.scene)]).parts
    assert _titles(run) == [
        "Bird's eye view: x to the right, y up",
        "Following view",
        "Friction circles, limit = 1",
        "What did it do? Steering delta_f [rad]",
        "Torque T_r [N.m]",
        "What did it feel? Yaw rate r [rad/s]",
        "Acceleration [m/s2]",
        "How hard was it? Share of friction limit [1]",
        "Path error [m], left positive",
        "How fast was it? Speed v_x [m/s]",
        f"Wall time per step [{MICROSECONDS}]",
        "When was what? Modes and solver status",
        "Events",
    ]
    assert (signals.title, about.title) == ("All signals", "About this run")


def test_limits_are_drawn_with_what_they_limit():
    run = screen.screen([RunPicture(STATIC.system, STATIC.scene)]).parts[0]
    torque = next(view for view in _views(run) if view.title == "Torque T_r [N.m]")
    assert set(torque.contents) == {
        "/signals/controller/actuation/T_r",
        "/limits/controller/actuation/T_r/upper",
        "/limits/controller/actuation/T_r/lower",
    }
    speed = next(view for view in _views(run) if "Speed" in view.title)
    assert "/limits/plant/state/v_x/upper" in speed.contents
    friction = next(view for view in _views(run) if "Share" in view.title)
    assert [part for part in friction.contents if part.startswith("/limits")] == ["/limits/plant/tyre/mu_f/upper"]


def test_several_runs_share_their_views_one_signal_each():
    runs = [RunPicture(STATIC.system, STATIC.scene, name, i, timed=False) for i, name in enumerate("ab")]
    extra = screen.Series("difference", ["/difference/b/x"])
    made = screen.screen(runs, [extra]).parts[0]
    assert "Acceleration a_y [m/s2]" in _titles(made)
    assert extra in _views(made)
    assert not any("Wall time" in title for title in _titles(made))
    yaw = next(view for view in _views(made) if "Yaw rate" in view.title)
    assert yaw.contents == ["/signals/a/plant/state/r", "/signals/b/plant/state/r"]
    assert yaw.legend
    birds_eye = _views(made)[0]
    assert birds_eye.origin == "/world/a/follow"
    assert birds_eye.trails == ["/world/a/trail", "/world/b/trail"]


@pytest.mark.parametrize("scene", [None, STATIC.scene])
def test_empty_plugs_have_a_screen(scene):
    idle = prepare("idle", Options(mode="blocks"))
    titles = _titles(screen.screen([RunPicture(idle.system, scene)]))
    assert ("Following view" in titles) == (scene is not None)
    assert "Path error [m], left positive" not in titles
