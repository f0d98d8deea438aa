"""FMUs of FMI 1.0 as units, against FMPy's own simulation of the same files: Co-Simulation and Model Exchange.

With it `fmus/toolchain/fmi1_description.py` and `fmus/units/fmi1_model.py`.
"""
# pyright: basic
# FMPy carries few types.

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from fmpy import simulate_fmu

from components.interfaces.problem import RequestError
from fmus.reading.opening import open_fmu
from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import Version
from fmus.units.make import fmu_unit
from fmus.units.unit import NoResetError
from orchestrator import Options, load
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import C, copied, description1, library, pack, scalar1

TYPES = (
    '<UnitDefinitions><BaseUnit unit="m"><DisplayUnitDefinition displayUnit="km" gain="0.001"/></BaseUnit>'
    '</UnitDefinitions><TypeDefinitions><Type name="Length"><RealType unit="m" min="-1e3"/></Type><Type name="Mode">'
    '<EnumerationType><Item name="off"/><Item name="on"/></EnumerationType></Type></TypeDefinitions>'
    '<DefaultExperiment startTime="0" stopTime="2" tolerance="1e-6"/>'
)
DISCRETE = {"variability": "discrete"}
SLAVE = [
    scalar1("x", 0, causality="output", depends="", of_declaredType="Length"),
    scalar1("minus_x", 0, causality="output", alias="negatedAlias", depends=""),
    scalar1("same_x", 0, alias="alias"),
    scalar1("k", 1, variability="parameter", of_start="1", of_fixed="true"),
    scalar1("rate", 1, variability="parameter", alias="alias"),
    scalar1("half_life", 6, variability="parameter"),
    scalar1("x_start", 3, variability="parameter", of_start="0"),
    scalar1("u", 2, causality="input", of_start="1"),
    scalar1("stop", 4, causality="output", depends=""),
    scalar1("sum", 5, causality="output", depends="u"),
    scalar1("unknown", 5, causality="output"),
    scalar1("n", 0, "Integer", causality="output", depends="", **DISCRETE),
    scalar1("minus_n", 0, "Integer", causality="output", alias="negatedAlias", depends="", **DISCRETE),
    scalar1("mode", 1, "Enumeration", causality="output", depends="", of_declaredType="Mode", **DISCRETE),
    scalar1("wanted", 2, "Enumeration", causality="input", of_declaredType="Mode", of_start="1", **DISCRETE),
    scalar1("is_on", 0, "Boolean", causality="output", depends="", **DISCRETE),
    scalar1("on", 1, "Boolean", causality="input", of_start="true", **DISCRETE),
    scalar1("text", 0, "String", causality="output", depends="", **DISCRETE),
    scalar1("said", 1, "String", variability="parameter", of_start="hello"),
    scalar1("unused", 7, causality="none"),
]


@pytest.fixture(scope="module")
def slave(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slave")
    binary = library(folder, Version.FMI1, '#include "slave1.c"')
    return pack(folder / "m.fmu", Version.FMI1, description1(SLAVE, before=TYPES), binary)


HELD = {"m.u": 3.0, "m.wanted": 2, "m.on": True}


def test_a_slave_runs_as_fmpy_runs_it(slave):
    start = {"k": 2.0, "x_start": 0.5}
    source = Fmu(slave, parameters={**start, "said": "hello"})
    rows = simulate(System({"m": source}, {}, held=HELD), h=0.1, until=2.0)
    theirs = simulate_fmu(
        str(slave),
        stop_time=2.0,
        output_interval=0.1,
        start_values={**start, "u": 3.0, "wanted": 2, "on": True},
        output=["x", "sum", "n", "mode", "is_on"],
    )
    for name in ("x", "sum", "n"):
        np.testing.assert_allclose(rows[f"m.{name}"], theirs[name], rtol=0, atol=1e-9)
    assert rows["m.mode"].tolist() == theirs["mode"].tolist()
    assert rows["m.is_on"].tolist() == theirs["is_on"].tolist()
    assert rows["m.text"].tolist() == ["", *["hello"] * 20]
    assert rows["m.stop"].tolist() == [-1.0] * 21


def test_a_slave_is_reset_and_runs_again(slave):
    system = System({"m": Fmu(slave, {"k": 2.0, "x_start": 0.5, "said": "hello"})}, {}, held=HELD)
    with Simulation(system, h=0.1, until=1.0) as simulation:
        simulation.run()
        expected, unit = simulation.frame(), simulation._running.by_name["m"]
        simulation.reset()
        simulation.run()
        assert simulation._running.by_name["m"] is unit
        assert simulation.frame().equals(expected)


def test_a_negated_alias_has_the_other_sign(slave):
    rows = simulate(System({"m": Fmu(slave)}, {}, held=HELD), h=0.1, until=1.0)
    assert rows["m.minus_x"].tolist() == (-rows["m.x"]).tolist()
    assert rows["m.minus_n"].tolist() == (-rows["m.n"]).tolist()
    assert rows["m.x"].iloc[-1] > 1.8


def test_an_input_may_be_a_negated_alias_too(slave, tmp_path):
    variables = [scalar1("v", 2, causality="input", alias="negatedAlias"), scalar1("u", 2), SLAVE[0]]
    path = copied(slave, tmp_path / "m.fmu", {"modelDescription.xml": description1(variables, before=TYPES).encode()})
    rows = simulate(System({"m": Fmu(path)}, {}, held={"m.v": -3.0}), h=0.1, until=1.0)
    expected = simulate(System({"m": Fmu(slave)}, {}, held=HELD), h=0.1, until=1.0)
    assert rows["m.x"].tolist() == expected["m.x"].tolist()


def test_what_the_description_says_is_read_in_the_words_of_the_other_versions(slave):
    archive = open_fmu(slave)
    found = archive.interface
    assert archive.version is Version.FMI1
    assert archive.remarks == ()
    assert [v.name for v in found.inputs] == ["u", "wanted", "on"]
    assert [v.name for v in found.parameters] == ["k", "x_start", "said"]  # one without a start value is computed
    assert found.aliases == {"same_x": "x", "rate": "k"}
    assert found.starts == {"k": 1.0, "x_start": 0.0, "u": 1.0, "wanted": 1, "on": True, "said": "hello"}
    x = next(v for v in found.outputs if v.name == "x").quantity
    assert (x.unit, x.min) == ("m", -1000.0)
    feeds = {v.name: row.tolist() for v, row in zip(found.outputs, found.feedthrough, strict=True)}
    assert (feeds["x"], feeds["sum"], feeds["unknown"]) == ([False] * 3, [True, False, False], [True] * 3)
    assert found.undeclared == {"unknown"}
    mode = next(v for v in found.outputs if v.name == "mode").quantity
    assert {item.name: item.value for item in mode.enumeration or ()} == {"off": 1, "on": 2}
    assert (archive.suggested.stop, archive.suggested.tolerance, archive.suggested.step) == (2.0, 1e-6, None)


def test_two_slaves_are_connected_and_one_runs_in_a_process_of_its_own(slave):
    wiring = {"b.u": "a.x", "b.wanted": "a.mode", "b.on": "a.is_on"}
    held = {f"a.{name[2:]}": value for name, value in HELD.items()}
    alone = simulate(System({"a": Fmu(slave), "b": Fmu(slave)}, wiring, held=held), h=0.1, until=1.0)
    apart = simulate(System({"a": Fmu(slave), "b": Fmu(slave, isolated=30.0)}, wiring, held=held), h=0.1, until=1.0)
    assert alone.equals(apart)
    assert 0.5 < alone["b.x"].iloc[-1] < alone["a.x"].iloc[-1]


def test_a_scenario_of_one_says_what_it_is(slave):
    scenario = load(str(slave), Options(step=0.1))
    with Simulation(scenario.system, h=scenario.h, until=scenario.until) as simulation:
        simulation.run()
        assert len(simulation.frame()) == 21
    assert next(iter(scenario.system.units.values())).describe().runs_as == "FMI 1.0"


def test_a_slave_that_needs_the_stop_time_is_told(slave, tmp_path):
    binary = library(tmp_path / "c", Version.FMI1, '#define NEEDS_STOP\n#include "slave1.c"')
    path = copied(slave, tmp_path / "m.fmu", {binary_path(Version.FMI1, "m"): binary.read_bytes()})
    rows = simulate(System({"m": Fmu(path)}, {}, held=HELD), h=0.1, until=1.0)
    assert rows["m.stop"].tolist() == [1.0] * 11
    assert rows["m.x"].iloc[-1] > 1.8


def test_a_wrong_guid_is_told_with_what_the_slave_says(slave, tmp_path):
    text = description1(SLAVE, before=TYPES, guid="other")
    path = copied(slave, tmp_path / "m.fmu", {"modelDescription.xml": text.encode()})
    with pytest.raises(RequestError) as error:
        fmu_unit("m", open_fmu(path))
    assert str(error.value).replace(f"{tmp_path}/", "") == (
        "m.fmu: found a library that refuses to make an instance (the GUID is g, not other); valid: a library that"
        " takes the GUID `other` of its modelDescription.xml. Export the FMU again."
    )


def test_a_step_that_fails_ends_the_run(slave, tmp_path):
    source = (C / "slave1.c").read_text().replace("if (!fresh)", "if (t > 0.25)")
    path = copied(slave, tmp_path / "m.fmu", {})
    binary = library(tmp_path / "c", Version.FMI1, source)
    path = copied(slave, tmp_path / "m.fmu", {binary_path(Version.FMI1, "m"): binary.read_bytes()})
    with pytest.raises(SimulationError) as error:
        simulate(System({"m": Fmu(path)}, {}, held=HELD), h=0.1, until=1.0)
    assert str(error.value) == "tick 3 (t = 0.3 s), unit `m`: `fmiDoStep` returned an error"


def test_sources_of_fmi_1_are_compiled(slave, tmp_path):
    """FMI 1.0 declares no source files; its headers are part of them, as here the one of FMPy."""
    required_compiler()
    place = binary_path(Version.FMI1, "m")
    made = {"sources/slave1.c": (C / "slave1.c").read_bytes(), place: None}
    path = copied(slave, tmp_path / "m.fmu", made)
    found = open_fmu(path)
    assert "compiled here from slave1.c in its folder of sources, which it does not declare" in found.remarks[0]
    unit = fmu_unit("m", found)
    unit.close()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "<Name>u</Name>",
            "<Name>w</Name>",
            "line 14: found `Name` of Name, variable w, which is not there; valid: what the file declares",
        ),
        (
            'declaredType="Length"',
            'declaredType="Width"',
            "line 5: found the declared type `Width`, which is not there; valid: what the file declares",
        ),
        (
            'alias="negatedAlias"',
            'alias="negated"',
            "line 6: found Element 'ScalarVariable', attribute 'alias': [facet 'enumeration'] The value 'negated' is"
            " not an element of the set {'noAlias', 'alias', 'negatedAlias'}; valid: what FMI 1.0 allows."
            " Have the file corrected by its maker, or run it as it is with --lenient.",
        ),
    ],
)
def test_descriptions_that_break_rules_are_refused_with_their_line(slave, tmp_path, old, new, message):
    text = description1(SLAVE, before=TYPES).replace(old, new)
    path = copied(slave, tmp_path / "m.fmu", {"modelDescription.xml": text.encode()})
    with pytest.raises(RequestError) as error:
        open_fmu(path)
    found = str(error.value).splitlines()
    assert f"{path}, modelDescription.xml, {message}" in found


BALL = [
    scalar1("h", 1, causality="output", depends="", of_start="1"),
    scalar1("v", 2, causality="output", depends="", of_start="0"),
    scalar1("g", 5, variability="parameter", of_start="9.81"),
    scalar1("e", 6, variability="parameter", of_start="0.7"),
    scalar1("bounces", 7, causality="output", variability="discrete", depends=""),
]
STIFF = [
    scalar1("x1", 1, causality="output", depends="", of_start="2"),
    scalar1("x2", 2, causality="output", depends="", of_start="1"),
    scalar1("u", 5, causality="input", of_start="0"),
    scalar1("y", 6, causality="output", depends="u"),
]
CLOCKWORK = [
    scalar1("x", 1, causality="output", depends="", of_start="0"),
    scalar1("gate", 4, "Boolean", causality="input", variability="discrete", of_start="false"),
    scalar1("openings", 5, causality="output", variability="discrete", depends="gate"),
    scalar1("end", 7, variability="parameter", of_start="1e9"),
    scalar1("iterations", 8, variability="parameter", of_start="0"),
]


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    """The models of Model Exchange, which the other versions share, by name."""
    made = {}
    for name, variables, counts in (("ball", BALL, (2, 1)), ("stiff", STIFF, (2, 0)), ("clockwork", CLOCKWORK, (1, 0))):
        folder = tmp_path_factory.mktemp(name)
        binary = library(folder, Version.FMI1, f'#define MODEL "{name}.h"\n#include "me1.c"')
        text = description1(variables, implementation="", guid="me", counts=counts)
        made[name] = pack(folder / "m.fmu", Version.FMI1, text, binary)
    return made


def test_a_bouncing_ball_follows_its_solution_and_fmpy(models):
    rows = simulate(System({"m": Fmu(models["ball"])}, {}), h=0.1, until=2.0)
    with warnings.catch_warnings(action="ignore"):
        theirs = simulate_fmu(
            str(models["ball"]), stop_time=2.0, output_interval=0.1, relative_tolerance=1e-8, output=["h", "bounces"]
        )
    np.testing.assert_allclose(rows["m.h"].iloc[:5], [1 - 9.81 / 2 * t * t for t in rows["time"].iloc[:5]], atol=1e-9)
    assert rows["m.bounces"].iloc[-1] == theirs["bounces"][-1] == 4
    regular = [next(i for i, t in enumerate(theirs["time"]) if abs(t - when) < 1e-9) for when in rows["time"]]
    np.testing.assert_allclose(rows["m.h"], theirs["h"][regular], rtol=0, atol=1e-6)


def test_a_model_has_no_reset_and_is_opened_again(models):
    with Simulation(System({"m": Fmu(models["ball"])}, {}), h=0.1, until=1.0) as simulation:
        simulation.run()
        expected, unit = simulation.frame(), simulation._running.by_name["m"]
        with pytest.raises(NoResetError, match="it has no reset"):
            unit.reset()
        simulation.reset()
        simulation.run()
        assert simulation._running.by_name["m"] is not unit
        assert simulation.frame().equals(expected)


def test_a_stiff_model_follows_its_input(models):
    """The same file as for the other versions, whose tests compare it with its analytic solution."""
    rows = simulate(System({"m": Fmu(models["stiff"])}, {}, held={"m.u": 0.0}), h=0.1, until=1.0)
    with warnings.catch_warnings(action="ignore"):
        theirs = simulate_fmu(
            str(models["stiff"]), stop_time=1.0, output_interval=0.1, relative_tolerance=1e-8, output=["x1", "x2"]
        )
    for name in ("x1", "x2"):
        np.testing.assert_allclose(rows[f"m.{name}"], theirs[name], rtol=0, atol=1e-6)


def test_time_events_and_input_events_happen_when_they_are_due(models):
    system = System({"m": Fmu(models["clockwork"])}, {}, held={"m.gate": True})
    rows = simulate(system, h=0.1, until=1.0)
    expected = [t if t <= 0.25 else 0.25 + 2 * (t - 0.25) if t <= 0.75 else 1.25 + 4 * (t - 0.75) for t in rows["time"]]
    np.testing.assert_allclose(rows["m.x"], expected, rtol=0, atol=1e-9)
    assert rows["m.openings"].tolist()[-1] == 1.0


def test_a_model_that_ends_the_run_ends_it(models):
    source = Fmu(models["clockwork"], parameters={"end": 0.55})
    with Simulation(System({"m": source}, {}, held={"m.gate": False}), h=0.1, until=1.0) as simulation:
        simulation.run()
        times = simulation.frame()["time"]
    assert times.iloc[-1] < 0.65
    assert math.isclose(times.iloc[4], 0.4)
