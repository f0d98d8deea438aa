"""When clocks tick and steps end, with an FMU written in Python; a real one with clocks runs in `test_clocked_unit`."""

from __future__ import annotations

import pytest
from fmpy.fmi3 import fmi3IntervalChanged, fmi3IntervalNotYetKnown

from fmus.clock import Clock
from fmus.units import event_mode
from fmus.units.event_mode import EventError, EventMode, StepResult
from fmus.units.unit import EndRequested


class Fmu:
    """Notes what happens to it; its countdown counts down as often as it is told."""

    def __init__(self, countdowns=()):
        self.said = []
        self.countdowns = list(countdowns)
        self.iterations = 1
        self.ends = False

    def enterEventMode(self):  # noqa: N802 - FMPy's name
        self.said.append("event mode")

    def enterStepMode(self):  # noqa: N802
        self.said.append("step mode")

    def setClock(self, references, values):  # noqa: N802
        assert all(values)
        self.said.append(("ticks", *references))

    def getClock(self, references):  # noqa: N802
        return [True for _ in references]

    def updateDiscreteStates(self):  # noqa: N802
        self.iterations -= 1
        return self.iterations > 0, self.ends

    def getIntervalDecimal(self, references, intervals, qualifiers):  # noqa: N802
        (_,) = references
        intervals[0] = self.countdowns.pop(0) if self.countdowns else 0.0
        qualifiers[0] = fmi3IntervalChanged if intervals[0] else fmi3IntervalNotYetKnown


PERIODIC = Clock("c", "input", "constant", reference=1, interval=0.04, shift=0.0)
COUNTDOWN = Clock("d", "input", "countdown", reference=2)
OUTPUT = Clock("o", "output", "triggered", reference=3)
TRIGGERED = Clock("t", "input", "triggered", reference=4)


def begun(fmu, *clocks):
    mode = EventMode("m", fmu, clocks, 0.1)
    mode.prepare()
    mode.begin()
    return mode


def whole(t, h):
    return StepResult(0, interrupted=False, terminate=False, reached=t + h)


def test_a_step_stops_at_every_tick_within_it():
    fmu, parts = Fmu(), []
    mode = begun(fmu, PERIODIC)
    mode.activate(0.0)
    mode.update(0.0)
    assert mode.step(lambda t, h: parts.append((round(t, 9), round(h, 9))) or whole(t, h), 0.0, 0.1) == 0
    assert parts == [(0.0, 0.04), (0.04, 0.04), (0.08, 0.02)]
    assert fmu.said == [("ticks", 1), *["step mode", "event mode", ("ticks", 1)] * 2, "step mode"]


def test_a_countdown_ticks_once_for_each_interval():
    fmu, parts = Fmu([0.03]), []
    mode = begun(fmu, COUNTDOWN)
    mode.step(lambda t, h: parts.append(round(t + h, 9)) or whole(t, h), 0.0, 0.1)
    assert parts == [0.03, 0.1]


def test_output_clocks_are_handed_over_once_and_triggered_ones_tick_at_the_next_instant():
    fmu = Fmu()
    mode = begun(fmu, OUTPUT, TRIGGERED)
    mode.update(0.0)
    assert mode.take_fired() == {"o"}
    assert mode.take_fired() == set()
    mode.trigger("t")
    mode.activate(0.1)
    assert mode.active == {4}
    mode.update(0.1)
    assert mode.active == frozenset()
    mode.activate(0.2)
    assert mode.active == frozenset()


def test_a_failed_step_is_a_status_and_what_cannot_go_on_an_error(monkeypatch):
    monkeypatch.setattr(event_mode, "EVENT_ITERATIONS", 3)
    fmu = Fmu()
    mode = begun(fmu)
    assert mode.step(lambda *_: StepResult(3, interrupted=False, terminate=False, reached=0.0), 0.0, 0.1) == 3
    with pytest.raises(EndRequested, match=r"`m` asked for the end of the run at 0\.05 s"):
        mode.step(lambda *_: StepResult(0, interrupted=True, terminate=True, reached=0.05), 0.0, 0.1)
    with pytest.raises(EventError, match="it returned early from its step without having moved, at 0 s"):
        mode.step(lambda *_: StepResult(0, interrupted=False, terminate=False, reached=0.0), 0.0, 0.1)
    fmu.iterations = 100
    with pytest.raises(EventError, match=r"its discrete states do not come to rest at 0\.1 s \(3 iterations\)"):
        mode.update(0.1)
    fmu.ends = True
    with pytest.raises(EndRequested, match=r"`m` asked for the end of the run at 0\.1 s"):
        mode.update(0.1)
    with pytest.raises(EventError, match="the clock with value reference 1 has the interval -1 s"):
        begun(Fmu(), Clock("c", "input", "constant", reference=1, interval=-1.0))
