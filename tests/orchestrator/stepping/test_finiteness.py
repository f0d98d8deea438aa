"""Values that are infinite or not a number: what ends a run, what is allowed, and what is told."""

from __future__ import annotations

import json
import math
from typing import final

import pandas as pd
import pytest

from components.interfaces.block import Block, block
from components.interfaces.buses import Motion, Tyre, VehicleState
from components.interfaces.maths import sqrt
from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from components.interfaces.sockets import PLANT, PlantInputs
from components.vehicle.single_track import SingleTrackOutputs
from fmus.toolchain.version import Version
from orchestrator.execution import Execution, execute
from orchestrator.loading import load
from orchestrator.scenario import catalogue
from orchestrator.scenario.options import Options
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description2, description3, library, pack, scalar
from tests.orchestrator.ssps import component, connectors, echo_library, wire, write

RADAR = """
#include <math.h>
#include "fmi3Functions.h"
#include <stdlib.h>
fmi3Instance fmi3InstantiateCoSimulation(fmi3String n, fmi3String t, fmi3String r, fmi3Boolean v, fmi3Boolean l,
    fmi3Boolean e, fmi3Boolean early, const fmi3ValueReference *req, size_t nreq, fmi3InstanceEnvironment env,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback cb) { return calloc(1, sizeof(double)); }
fmi3Status fmi3GetFloat64(fmi3Instance i, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t m) {
    for (size_t k = 0, at = 0; k < n; k++) {
        double t = *(double *)i;
        if (vr[k] == 1) v[at++] = t > 0.15 && t < 0.45 ? INFINITY : 5;
        if (vr[k] == 2) { v[at++] = 1; v[at++] = t > 0.35 ? NAN : 2; }
    }
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance i, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no, fmi3Boolean *ev, fmi3Boolean *end,
    fmi3Boolean *early, fmi3Float64 *last) { *(double *)i = t + h; *ev = *end = *early = 0; return fmi3OK; }
"""


def radar(path, declared=""):
    """It shows the time to collision, infinite from 0.2 to 0.4 s, and an array `x`, in part NaN from 0.4 s on."""
    made = library(path.parent / "radar", Version.FMI3, RADAR)
    variables = [
        f'<Float64 name="ttc" valueReference="1" causality="output" {declared}/>',
        '<Float64 name="x" valueReference="2" causality="output"><Dimension start="2"/></Float64>',
    ]
    structure = [f'<Output valueReference="{i}" dependencies=""/>' for i in (1, 2)]
    structure += [f'<InitialUnknown valueReference="{i}"/>' for i in (1, 2)]
    return pack(path, Version.FMI3, description3(variables, structure), made)


def acc(path, start="0"):
    """It shows what it received, one step later."""
    variables = [
        f'<Float64 name="u" valueReference="1" causality="input" start="{start}"/>',
        '<Float64 name="y" valueReference="101" causality="output"/>',
    ]
    structure = ['<Output valueReference="101" dependencies=""/>', '<InitialUnknown valueReference="101"/>']
    return pack(path, Version.FMI3, description3(variables, structure), echo_library(Version.FMI3))


@final
@block(PLANT)
class Skidding(Block[PlantInputs, VehicleState, SingleTrackOutputs]):
    """Plant that goes straight ahead, and shows tyres that are not finite at first, and not a number after 5 m."""

    def start(self):
        """At the origin."""
        return VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0, v_y=0.0, r=0.0)

    def output(self, x, u):
        """Slip angles as of a model that divides by what may be 0."""
        tyre = Tyre(alpha_f=1 / x.x, alpha_r=0.0, F_cf=0.0, F_cr=0.0, mu_f=sqrt(5.0 - x.x), mu_r=0.0)
        motion = Motion(a_x=0.0, a_y=0.0, r_dot=0.0)
        return SingleTrackOutputs(state=x, tyre=tyre, motion=motion)

    def step(self, x, u, h):
        """Straight ahead."""
        return VehicleState(x=x.x + h * x.v_x, y=x.y, psi=x.psi, v_x=x.v_x, v_y=x.v_y, r=x.r)


def wired(folder, declared="", start="0", **made):
    units = {"radar": Fmu(radar(folder / "radar.fmu", declared)), "acc": Fmu(acc(folder / "acc.fmu", start))}
    return System(units, {"acc.u": "radar.ttc"}, **made)


def ran(system):
    with Simulation(system, h=0.1, until=0.6) as simulation:
        simulation.run()
        return simulation.frame(), simulation.remarks


def test_what_no_unit_reads_is_recorded_and_told_once(tmp_path):
    frame, remarks = ran(System({"radar": Fmu(radar(tmp_path / "radar.fmu"))}, {}))
    assert frame["radar.ttc"].tolist() == [5, 5, math.inf, math.inf, math.inf, 5, 5]
    assert frame["radar.x[2]"].isna().tolist() == [False] * 4 + [True] * 3
    told = "`radar.ttc` (inf first at 0.2 s), `radar.x[2]` (nan first at 0.4 s)"
    assert remarks == [f"values that are not finite: {told}"]


def test_what_a_unit_reads_ends_the_run_and_the_message_says_how_to_allow_it(tmp_path):
    with pytest.raises(SimulationError) as error:
        ran(wired(tmp_path))
    assert error.value.unit == "radar"
    assert error.value.reason == (
        "the signal `radar.ttc` is inf, which `acc.u` would receive; --allow-nonfinite 'radar.ttc' lets it pass"
    )


@pytest.mark.parametrize(
    ("declared", "start", "patterns"),
    [
        ("", "0", ["radar.ttc"]),
        ("", "0", ["radar.t*"]),
        ('max="INF"', "0", []),
        ('initial="exact" start="NaN"', "0", []),
        ("", "INF", []),
    ],
)
def test_it_is_allowed_by_pattern_and_by_the_files(tmp_path, declared, start, patterns):
    frame, remarks = ran(wired(tmp_path, declared, start, allow_nonfinite=patterns))
    assert frame["acc.y"].tolist()[3:6] == [math.inf] * 3
    told = [] if patterns or declared else ["`radar.ttc` (inf first at 0.2 s)"]
    told += ["`acc.y` (inf first at 0.3 s)"]
    assert all(text in remarks[0] for text in told)
    assert ("radar.ttc" in remarks[0]) == (not patterns and not declared)


def test_an_element_of_an_array_is_allowed_by_its_name_or_that_of_the_array(tmp_path):
    units = {"radar": Fmu(radar(tmp_path / "radar.fmu")), "acc": Fmu(acc(tmp_path / "acc.fmu"))}
    for patterns in (["radar.x"], ["radar.x[2]"]):
        frame, _ = ran(System(units, {"acc.u": "radar.x[2]"}, allow_nonfinite=patterns))
        assert len(frame) == 7
    with pytest.raises(SimulationError, match=r"--allow-nonfinite 'radar.x\[2\]' lets it pass"):
        ran(System(units, {"acc.u": "radar.x[2]"}, allow_nonfinite=["radar.x[1]"]))
    frame, remarks = ran(System(units, {"acc.u": "radar.x[1]"}))
    assert len(frame) == 7
    assert "`radar.x[2]` (nan first at 0.4 s)" in remarks[0]


def test_a_pattern_that_fits_no_output_is_refused(tmp_path):
    with pytest.raises(RequestError) as error:
        wired(tmp_path, allow_nonfinite=["radar.tcc"])
    assert str(error.value) == (
        "allow_nonfinite radar.tcc: found a pattern that no output fits; valid: acc.y, radar.ttc, radar.x, radar.x[1],"
        " radar.x[2]. Did you mean `radar.ttc`?"
    )


def theirs(folder):
    parts = component("radar", "radar.fmu", connectors("ttc:output"))
    parts += component("acc", "acc.fmu", connectors("u:input", "y:output"))
    connections = f"<ssd:Connections>{wire('radar.ttc', 'acc.u')}</ssd:Connections>"
    files = {"resources/radar.fmu": radar(folder / "radar.fmu"), "resources/acc.fmu": acc(folder / "acc.fmu")}
    return write(folder / "s.ssp", f"<ssd:Elements>{parts}</ssd:Elements>{connections}", files)


@pytest.mark.parametrize(("options", "told"), [({"lenient": True}, True), ({"allow_nonfinite": ["radar.ttc"]}, False)])
def test_a_run_that_allows_it_is_repeated_from_its_folder(tmp_path, options, told):
    loaded = load(str(theirs(tmp_path)), Options(stop_time=0.6, **options))
    first = execute(loaded, tmp_path / "r1", SILENT, Execution())
    again = execute(load(str(tmp_path / "r1")), tmp_path / "r2", SILENT, Execution())
    assert (first.ended, again.ended, first.notes) == (None, None, again.notes)
    assert any("`radar.ttc` (inf first at 0.2 s)" in note for note in first.notes) is told
    names = ("r1/signals.parquet", "r2/signals.parquet")
    one, other = ((tmp_path / name).read_bytes() for name in names)
    assert one == other
    frame = pd.read_parquet(tmp_path / "r2" / "signals.parquet")
    assert frame["radar.ttc"].tolist() == [5, 5, math.inf, math.inf, math.inf, 5, 5]
    text = (tmp_path / "r1" / "summary.json").read_text()
    found = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))["not_finite"]
    assert found["radar.ttc"] == {"first": 0.2, "value": "inf"}
    assert found["radar.x[2]"]["value"] == "nan"


def test_figures_metrics_and_the_recording_survive_it(tmp_path, monkeypatch):
    monkeypatch.setattr(catalogue, "BLOCKS", {**catalogue.BLOCKS, "skidding": Skidding})
    replacements = {"plant": "skidding", "controller": "lqr"}
    made = {"mode": "blocks", "stop_time": 1.0, "replacements": replacements}
    finished = execute(load("static", Options(**made)), tmp_path / "r", SILENT, Execution())
    assert str(finished.ended) == (
        "tick 0 (t = 0 s), unit `plant`: the signal `plant.tyre.alpha_f` is inf;"
        " --allow-nonfinite 'plant.tyre.alpha_f' lets it pass"
    )
    loaded = load("static", Options(**made, lenient=True))
    finished = execute(loaded, tmp_path / "r", SILENT, Execution())
    assert finished.ended is None
    told = "`plant.tyre.alpha_f` (inf first at 0 s), `plant.tyre.mu_f` (nan first at 0.6 s)"
    assert [note for note in finished.notes if "recording" in note or "finite" in note] == [
        f"values that are not finite: {told}"
    ]
    assert "figures" not in finished.summary
    assert list((tmp_path / "r" / "figures").glob("*.png"))
    frame = pd.read_parquet(tmp_path / "r" / "signals.parquet")
    assert math.isinf(frame["plant.tyre.alpha_f"][0])
    metrics = finished.summary["metrics"]
    assert metrics["mu_f_max"] == pytest.approx(2.0)  # of the rows in which the tyres are finite
    assert metrics["gap_obstacle"] > 0


def test_without_leave_the_system_of_another_maker_ends_in_a_fault(tmp_path):
    loaded = load(str(theirs(tmp_path)), Options(stop_time=0.6))
    finished = execute(loaded, tmp_path / "r", SILENT, Execution())
    assert isinstance(finished.ended, SimulationError)
    assert len(pd.read_parquet(tmp_path / "r" / "signals.parquet")) == 3
    assert finished.notes == ()


def test_start_values_that_are_not_finite_are_those_of_fmi_3_or_taken_leniently(tmp_path):
    loaded = load(str(acc(tmp_path / "a.fmu", "-INF")), Options(stop_time=0.2))
    frame, _ = ran(loaded.system)
    assert frame["fmu.y"].tolist()[1] == -math.inf
    variables = [
        scalar("u", 1, "input", of_start="NaN"),
        scalar("p", 2, "parameter", variability="fixed", of_start="1"),
    ]
    text = description2(
        [*variables, scalar("y", 101, "output")], ['<Unknown index="3"/>'], initial=['<Unknown index="3"/>']
    )
    path = pack(tmp_path / "b.fmu", Version.FMI2, text, echo_library(Version.FMI2))
    with pytest.raises(RequestError) as error:
        load(str(path), Options(stop_time=0.2, settings=["fmu.p=inf"]))
    assert str(error.value).splitlines() == [
        "fmu.p: found inf; valid: finite number. Take it as it is with --lenient.",
        "fmu.u: found nan; valid: finite number. Take it as it is with --lenient.",
    ]
    loaded = load(str(path), Options(stop_time=0.2, settings=["fmu.p=inf"], lenient=True))
    execute(loaded, tmp_path / "r", SILENT, Execution())
    again = load(str(tmp_path / "r"))
    assert math.isnan(again.system.held["fmu.u"])
    assert again.system.units["fmu"].parameters == {"p": math.inf}
