"""The order of one macro step follows from what depends on what."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.schedule import open_dependencies_close_a_loop, schedule
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.experiment import Algorithm
from orchestrator.system.source import InProcess, block_source
from orchestrator.system.system import System
from tests.orchestrator.blocks import Gain, Held, Sum, system


def test_the_controller_acts_at_once_and_the_plant_shows_its_tyres_with_the_new_actuation():
    made = schedule(prepare("static", Options(mode="blocks")).system)
    assert str(made) == (
        "set controller; step controller; get controller; set plant; get plant;"
        " set traffic; step traffic; step plant; get traffic; get plant"
    )


@pytest.mark.parametrize("names", [("sum", "gain", "held"), ("held", "gain", "sum"), ("gain", "held", "sum")])
def test_no_delay_whatever_the_order_of_the_units(names):
    made = {"sum": Sum(), "gain": Gain(k=2.0), "held": Held()}
    wiring = {"gain.a": "sum.b", "held.a": "gain.b", "sum.a": "gain.b"}
    frame = simulate(system({n: made[n] for n in names}, wiring), h=0.5, until=2.0)
    assert frame["sum.b.value"].tolist() == [1, 3, 9, 27, 81]
    assert frame["gain.b.value"].tolist() == [2, 6, 18, 54, 162]
    assert frame["held.b.value"].tolist() == [1002, 2006, 3018, 4054, 5162]


def test_jacobi_sets_steps_and_gets_all_units_and_nothing_before():
    made = schedule(prepare("static", Options(mode="blocks")).system, Algorithm.JACOBI)
    assert str(made) == (
        "set plant; set traffic; set controller; step plant; step traffic; step controller;"
        " get plant; get traffic; get controller"
    )
    assert made.before == ()


def test_jacobi_shows_a_controller_one_step_late():
    """By hand: h shows at t_k what it sampled at t_{k-1}, s adds what h showed at t_k."""
    made = system({"s": Sum(), "h": Held()}, {"h.a": "s.b", "s.a": "h.b"})
    frame = simulate(made, h=1.0, until=4.0, algorithm="jacobi")
    s, h = [1.0], [1001.0]  # the initial outputs: the first sample, not yet counted
    for k in range(4):
        shown = h[-1]
        h.append(s[-1] + 1000 * (k + 1))
        s.append(s[-1] + shown)
    assert frame["s.b.value"].tolist() == s
    assert frame["h.b.value"].tolist() == h


def test_without_event_mode_clocked_is_sequential():
    made = prepare("static", Options(mode="blocks")).system
    assert str(schedule(made, Algorithm.CLOCKED)) == str(schedule(made))


def test_an_algebraic_loop_is_shown_as_its_chain():
    units = {"p": Gain(k=1.0), "q": Held(), "s": Sum()}
    with pytest.raises(RequestError) as error:
        schedule(system(units, {"p.a": "q.b", "q.a": "p.b", "s.a": "p.b"}))
    text = str(error.value)
    assert text.startswith("algebraic loop: found ")
    assert "p.b.value -> q.a.value" in text
    assert "q.b.value -> p.a.value" in text
    remedy = (
        " Break it with a unit whose output does not depend on its input at the same instant (a state, a delay), "
        "have it solved by iteration with --solve-loops, or exchange values one step late with --algorithm jacobi."
    )
    assert text.endswith(remedy)


def test_a_unit_fed_by_itself_is_a_loop():
    with pytest.raises(RequestError, match="algebraic loop: found g.b.value -> g.a.value"):
        schedule(system({"g": Gain(k=1.0)}, {"g.a": "g.b"}))


def test_a_loop_through_a_state_is_none():
    frame = simulate(system({"s": Sum(), "g": Gain(k=1.0)}, {"s.a": "g.b", "g.a": "s.b"}), h=1.0, until=3.0)
    assert frame["s.b.value"].tolist() == [1, 2, 4, 8]


class Seen(InProcess):
    """A block that looks from outside like an FMU of another kind."""

    changes: ClassVar[dict[str, Any]] = {}

    @property
    def interface(self) -> Any:
        return replace(super().interface, **self.changes)


def seen(unit, **changes):
    source = block_source(unit)
    return type("Changed", (Seen,), {"changes": changes})(source.block, source.parameters)


def test_event_mode_without_clocks_waits_for_its_inputs_as_a_late_unit_does():
    """Inputs that jump are an event of t_k; nobody needs what the unit shows then."""
    units = {"s": seen(Sum(), event_mode=True, output_after_set=False), "g": block_source(Held())}
    made = System(units, {"g.a": "s.b", "s.a": "g.b"})
    assert str(schedule(made, Algorithm.CLOCKED)) == (
        "set g; step g; get g; activate s; set s; update s; step s; get s"
    )
    assert str(schedule(made)) == "set g; step g; get g; set s; step s; get s"


def test_a_loop_that_only_open_dependencies_close_is_told_from_one_that_is_declared():
    wiring = {"g.a": "s.b", "s.a": "g.b"}
    silent = seen(
        Sum(), output_after_set=False, feedthrough=np.ones((1, 1), dtype=bool), undeclared=frozenset({"b.value"})
    )
    assert open_dependencies_close_a_loop(System({"s": silent, "g": block_source(Held())}, wiring))
    assert not open_dependencies_close_a_loop(system({"s": Gain(k=1.0), "g": Held()}, wiring))
    assert not open_dependencies_close_a_loop(system({"s": Sum(), "g": Held()}, wiring))
