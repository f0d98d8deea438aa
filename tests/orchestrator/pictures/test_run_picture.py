"""One run as shapes: any system, with signals of every type."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import pytest

from components.interfaces.items import Enumeration
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from fmus.unit_interface import Interface
from orchestrator import Options, metrics, shown, simulate
from orchestrator.pictures import drawing, palette, screen, shapes
from orchestrator.pictures.run_picture import MICROSECONDS, RunPicture
from orchestrator.recording.blueprint import blueprint
from orchestrator.recording.stream import ShapeBatch, write
from orchestrator.scenario.prepare import prepare
from orchestrator.system.system import System
from orchestrator.system.unit_source import UnitSource


class Gear(IntEnum):
    """A declared enumeration."""

    park = 1
    drive = 4


SIGNALS = {
    "heater.on": Quantity("", "switch", Type.BOOLEAN),
    "heater.T": Quantity("K", "temperature", Type.FLOAT32),
    "count": Quantity("", "events so far", Type.UINT64),
    "box.gear": Quantity("", "gear", Type.ENUMERATION, enumeration=Enumeration.of(Gear)),
    "box.torques": Quantity("N.m", "per wheel", shape=(2, 2)),
    "text.said": Quantity("", "message", Type.STRING),
    "text.lines": Quantity("", "messages", Type.STRING, shape=(2,)),
    "text.raw": Quantity("", "bytes", Type.BINARY),
}


@dataclass(frozen=True)
class Declared:
    """A unit that is only looked at."""

    interface: Interface
    parameters: dict = field(default_factory=dict)
    has_own_values: bool = False

    def single_instance(self):
        return None


UnitSource.register(Declared)


@pytest.fixture
def system():
    outputs = tuple(Variable(name, quantity) for name, quantity in SIGNALS.items())
    feedthrough = np.zeros((len(outputs), 0), dtype=bool)
    interface = Interface("foreign", (), outputs, (), feedthrough, output_after_set=True, starts={})
    return System(units={"unit": Declared(interface)}, wiring={})


@pytest.fixture
def rows():
    n = 4
    said = np.array(["ready", "ready", "steady", "go"], dtype=object)
    return {
        "time": np.arange(n) * 0.5,
        "unit.heater.on": np.array([False, True, True, False]),
        "unit.heater.T": np.linspace(290, 300, n, dtype=np.float32),
        "unit.count": np.arange(n, dtype=np.uint64),
        "unit.box.gear": np.array([1, 1, 4, 2]),
        **{f"unit.box.torques[{i},{j}]": np.full(n, 10.0 * i + j) for i in (1, 2) for j in (1, 2)},
        "unit.text.said": said,
        "unit.text.lines[1]": said,
        "unit.text.lines[2]": said[::-1].copy(),
        "unit.text.raw": np.array([b"\0"] * n, dtype=object),
    }


def _by_entity(found, kind):
    return {shape.entity: shape for shape in found if isinstance(shape, kind)}


def test_signals_of_every_type_are_series_or_states(system, rows):
    found = list(RunPicture(system, None).shapes(rows, np.zeros(4)))
    values = _by_entity(found, shapes.SeriesValues)
    assert values.keys() == {
        "/signals/unit/heater/on",
        "/signals/unit/heater/T",
        "/signals/unit/count",
        "/signals/unit/box/gear",
        "/signals/unit/box/torques",
        "/performance/step_time",
    }
    assert values["/signals/unit/box/torques"].values[0].tolist() == [11, 12, 21, 22]
    states = {entity: list(state.names) for entity, state in _by_entity(found, shapes.States).items()}
    assert states == {
        "/states/unit/heater/on": ["false", "true", "false"],
        "/states/unit/box/gear": ["park", "drive", "2"],
        "/states/unit/text/said": ["ready", "steady", "go"],
        "/states/unit/text/lines\\[1\\]": ["ready", "steady", "go"],
        "/states/unit/text/lines\\[2\\]": ["go", "steady", "ready"],
    }


def test_states_are_sent_when_they_change_over_batches(system, rows):
    picture = RunPicture(system, None)
    told = []
    for i in range(4):
        batch = {name: values[i : i + 1] for name, values in rows.items()}
        told.append(_by_entity(picture.shapes(batch, None), shapes.States)["/states/unit/text/said"].names)
    assert told == [["ready"], [], ["steady"], ["go"]]


def test_a_foreign_system_has_views_by_unit_bus_and_physical_unit(system, rows, tmp_path):
    picture = RunPicture(system, None)
    made = screen.screen([picture])
    assert [part.title for part in made.parts[0].parts] == [
        "unit.heater.on",
        "unit.heater.T [K]",
        "unit.count",
        "unit.box.gear",
        "unit.box [N.m]",
        f"Wall time [{MICROSECONDS}] per step",
        "Modes and solver status",
    ]
    blueprint(made)
    batch = ShapeBatch(np.arange(4), 0.5 * np.arange(4), picture.shapes(rows, None))
    write(tmp_path / "run.rrd", "foreign", made, picture.styles(), [batch])
    assert (tmp_path / "run.rrd").stat().st_size > 1000


def test_in_a_comparison_every_series_has_the_runs_colour_and_name(system):
    picture = RunPicture(system, None, "second", 1)
    series = _by_entity(picture.styles(), shapes.SeriesStyle)
    assert series["/signals/second/unit/heater/T"].names == ["second"]
    assert series["/signals/second/unit/box/torques"].names[0] == "second torques[1,1] [N.m]"
    assert {colour for style in series.values() for colour in style.colours} == {palette.RUNS[1]}


def test_the_gap_to_the_nearest_obstacle_is_that_of_the_metrics_where_somebody_is_near():
    made = prepare("static", Options(mode="blocks"))
    frame = simulate(made.system, h=made.h, until=made.until)
    found = list(RunPicture(made.system, made.scene).shapes(frame, None))
    gap = _by_entity(found, shapes.SeriesValues)["/derived/gap_obstacle"]
    least = metrics.compute(frame, shown(made.system), made.scene)["gap_obstacle"]
    assert np.nanmin(gap.values) == pytest.approx(least, rel=1e-12)
    holes = np.isnan(gap.values)
    assert holes[0]
    assert not holes[1:].all()
    assert frame["plant.state.x"][gap.rows][~holes].min() > 49.5 - drawing.NEAR - 1
    assert len(holes) < len(frame)


def test_how_a_run_ended_is_told_line_by_line_what_is_wrong_first(system):
    about = {
        "verdicts": "task done: yes\ninside road: no",
        "metrics": "gap_edge -0.1 m\nmu_f_max 0.6",
        "out of range": "`plant.x` is 7 at t = 1 s, outside of what its unit declares (finite number <= 5)",
    }
    lines = RunPicture(system, None).ending(about)
    assert list(zip(lines.levels, lines.texts, strict=True)) == [
        ("WARN", "inside road: no"),
        ("WARN", "`plant.x` is 7 at t = 1 s, outside"),
        ("WARN", "  of what its unit declares"),
        ("WARN", "  (finite number <= 5)"),
        ("INFO", "task done: yes"),
        ("INFO", "gap_edge -0.1 m"),
        ("INFO", "mu_f_max 0.6"),
    ]
    assert RunPicture(system, None).ending({}).texts == []


def test_in_a_comparison_every_line_of_the_log_names_its_run(system):
    assert RunPicture(system, None, "b", 1).ending({"verdicts": "inside road: no"}).texts == ["b: inside road: no"]
