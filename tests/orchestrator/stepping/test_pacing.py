"""A run keeps pace with a clock; the clock here is one that tests move."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from components.interfaces.problem import RequestError
from orchestrator.stepping import pacing
from orchestrator.stepping.pacing import Pacer


@pytest.fixture
def clock(monkeypatch):
    """Seconds since some moment; sleeping takes 0.1 ms too long, as it does."""

    def sleep(seconds):
        clock.now += seconds + 1e-4

    clock = SimpleNamespace(now=1000.0, perf_counter=lambda: clock.now, sleep=sleep)
    monkeypatch.setattr(pacing, "time", clock)
    return clock


def run(clock, pacer, work):
    """The moments at which ticks begin that take `work` [s] each."""
    began = []
    for tick, seconds in enumerate(work):
        pacer.wait(tick)
        began.append(clock.now - 1000)
        clock.now += seconds
        pacer.done(tick)
    return began


def test_every_tick_has_its_own_moment_and_errors_do_not_add_up(clock):
    pacer = Pacer(2.0, 0.1)
    began = run(clock, pacer, [0.01] * 1001)
    assert began[1] == pytest.approx(0.05, abs=2e-4)
    assert began[1000] == pytest.approx(50.0, abs=2e-4)
    assert pacer.report() == {"factor": 2.0, "late_ticks": 0, "worst_s": 0.0}


def test_late_ticks_are_counted_and_made_up_for(clock):
    pacer = Pacer(1.0, 0.1)
    began = run(clock, pacer, [0.01, 0.01, 0.25, 0.06, 0.01, 0.01])
    # tick 2 ends at 0.45 instead of 0.3, tick 3 at 0.51 instead of 0.4, tick 4 at 0.52 instead of 0.5
    assert began == pytest.approx([0, 0.1, 0.2, 0.45, 0.51, 0.52], abs=3e-4)
    report = pacer.report()
    assert report["late_ticks"] == 3
    assert report["worst_s"] == pytest.approx(0.15, abs=3e-4)


@pytest.mark.parametrize("factor", [0.0, -1.0, float("inf"), float("nan")])
def test_a_factor_that_is_no_pace_is_refused(factor):
    with pytest.raises(RequestError) as error:
        Pacer(factor, 0.1)
    valid = "a positive number: 1 is real time, 2 twice as fast"
    assert str(error.value) == f"--realtime: found {factor:g}; valid: {valid}"
