"""The questions that are asked of a run, and the limits of the signals that answer."""

from __future__ import annotations

import pytest

from components import BLOCKS
from orchestrator.pictures import drawing, plots
from orchestrator.pictures.signals import Recorded, signals
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.shown import shown
from orchestrator.system.source import block_source
from orchestrator.system.system import System


@pytest.fixture(scope="module")
def static():
    return prepare("static", Options(mode="blocks"))


def test_known_limits_are_those_of_the_controllers_parameters(static):
    found = {limit.label: limit.value for limit in plots.limits(static.system, signals(static.system))}
    assert found["delta_max [rad]"] == -found["-delta_max [rad]"] > 0
    assert (found["T_dmax [N.m]"], found["-T_bmax [N.m]"], found["limit [1]"]) == (200, -160, 1)


def test_questions_without_an_answer_are_not_asked():
    plain = System(units={"rest": block_source(BLOCKS["empty_road"]())}, wiring={}, held=_resting())
    known = signals(plain)
    assert plots.questions(plain, known) == {}
    assert plots.limits(plain, known) == []
    assert not drawing.has_path_errors(Recorded(plain), shown(plain))
    assert [(plot.title, len(plot.signals)) for plot in plots.by_bus(known)] == [
        ("rest.obstacles [1]", 2),
        ("rest.obstacles [m]", 4),
        ("rest.obstacles psi [rad]", 1),
        ("rest.obstacles v [m/s]", 1),
    ]


def _resting():
    return {f"rest.ego.{name}": 0.0 for name in ("x", "y", "psi", "v_x", "v_y", "r")}


def test_a_plot_is_split_by_its_signals_each_with_its_own_limits(static):
    known = signals(static.system)
    (friction,) = plots.questions(static.system, known)[plots.HARD]
    assert (friction.title, len(friction.limits)) == ("Friction share [1]", 1)
    parts = friction.split(plots.limits(static.system, known))
    assert [part.title for part in parts] == ["Friction share mu_f [1]", "Friction share mu_r [1]"]
    assert [[limit.signal.path for limit in part.limits] for part in parts] == [
        ["plant.tyre.mu_f"],
        ["plant.tyre.mu_r"],
    ]
    (speed,) = plots.questions(static.system, known)[plots.FAST]
    assert speed.split([]) == [speed]
