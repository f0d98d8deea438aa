"""Local variables and parameters in the rows of a run, and systems of units without outputs."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from fmus.toolchain.version import Version
from orchestrator.execution import Execution, execute
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.observation import MOST_BY_DEFAULT
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description2, library, pack, scalar
from tests.fmus.model_exchange_models import ball2, stiff2
from tests.orchestrator.ssps import component, connectors, echo_library, write

U = scalar("u", 0, "input", of_start="4")
LOCALS = [
    scalar("tyre[1].F", 100, "local"),  # what the input was in the step before
    scalar("tyre[1].name", 101, "local", "String", variability="discrete"),
    scalar("debug", 1, "local"),
    scalar("k", 2, "parameter", variability="tunable", of_start="3"),
]


def fmu(path, variables=(U, *LOCALS), *, output=True):
    shown = [scalar("y", 100, "output")] if output else []
    unknown = [f'<Unknown index="{len(variables) + 1}" dependencies=""/>'] * output
    text = description2([*variables, *shown], unknown, initial=unknown)
    return pack(path, Version.FMI2, text, echo_library(Version.FMI2))


def me(path, model, text):
    made = library(path.parent / model, Version.FMI2, '#include "me2.c"', f'-DMODEL="{model}"')
    return pack(path, Version.FMI2, text, made)


def columns(path, **options):
    loaded = load(str(path), Options(stop_time=0.3, **options))
    with Simulation(loaded.system, h=loaded.h, until=loaded.until, record=loaded.record) as simulation:
        simulation.run()
        return {name: column.tolist() for name, column in simulation.columns().items()}, loaded.remarks


@pytest.mark.parametrize(
    ("patterns", "expected"),
    [
        ([], ["y"]),
        (["*"], ["y"]),
        (["fmu.*"], ["y"]),
        (["fmu.tyre[1].*"], ["tyre[1].F", "tyre[1].name"]),
        (["fmu.tyre[[]1].F"], ["tyre[1].F"]),
        (["fmu.y", "fmu.debug"], ["y", "debug"]),
        (["fmu.**"], ["y", "tyre[1].F", "tyre[1].name", "debug"]),
        (["fmu.**", "fmu.tyre*:0"], ["y", "debug"]),
        (["fmu.k"], ["k"]),
        (["*debug:0"], ["y"]),
    ],
)
def test_local_variables_are_recorded_where_they_are_asked_for(tmp_path, patterns, expected):
    found, _ = columns(fmu(tmp_path / "a.fmu"), record=patterns)
    assert list(found) == ["time", *(f"fmu.{name}" for name in expected)]


@pytest.mark.parametrize("isolate", [(), ("fmu",)])
def test_they_have_the_values_of_the_instant(tmp_path, isolate):
    found, _ = columns(
        fmu(tmp_path / "a.fmu"), settings=["fmu.k=3"], record=["fmu.**:2", "fmu.k", "fmu.y"], isolate=isolate
    )
    assert found["fmu.y"] == [0, 4, 4, 4]
    assert found["fmu.k"] == [3, 3, 3, 3]
    assert [found["fmu.tyre[1].F"][i] for i in (0, 2)] == [0, 4]
    assert found["fmu.tyre[1].name"] == [""] * 4


def test_a_unit_without_outputs_shows_its_local_variables(tmp_path):
    found, remarks = columns(fmu(tmp_path / "a.fmu", output=False))
    assert list(found) == ["time", "fmu.tyre[1].F", "fmu.tyre[1].name", "fmu.debug"]
    assert not any("has no outputs" in remark for remark in remarks)


def test_of_very_many_local_variables_the_first_are_recorded(tmp_path):
    many = [scalar(f"x{i}", i % 256, "local") for i in range(MOST_BY_DEFAULT + 5)]
    path = fmu(tmp_path / "a.fmu", [U, *many], output=False)
    found, remarks = columns(path)
    assert list(found)[-1] == f"fmu.x{MOST_BY_DEFAULT - 1}"
    assert (
        "`fmu` has no outputs: the first 1000 of its 1005 local variables are recorded; --record 'fmu.**' records all"
        " of them"
    ) in remarks
    found, remarks = columns(path, record=["fmu.**"])
    assert list(found)[-1] == f"fmu.x{MOST_BY_DEFAULT + 4}"
    assert not any("has no outputs" in remark for remark in remarks)


def test_a_system_with_nothing_to_record_runs_and_says_so(tmp_path):
    sink = fmu(tmp_path / "sink.fmu", [U], output=False)
    parts = component("a", "sink.fmu", connectors("u:input")) + component("b", "sink.fmu", connectors("u:input"))
    path = write(tmp_path / "s.ssp", f"<ssd:Elements>{parts}</ssd:Elements>", {"resources/sink.fmu": sink})
    for request in (path, sink):
        loaded = load(str(request), Options(stop_time=0.3))
        finished = execute(loaded, tmp_path / "r", SILENT, Execution())
        assert (finished.ended, finished.notes) == (None, ())
        assert pd.read_parquet(tmp_path / "r" / "signals.parquet").columns.tolist() == ["time"]
    text = "`fmu` has neither outputs nor local variables: there is nothing to record of it"
    assert text in loaded.remarks


def test_a_run_is_repeated_from_its_folder_with_what_it_recorded(tmp_path):
    loaded = load(str(fmu(tmp_path / "a.fmu")), Options(stop_time=0.3, record=["fmu.tyre[1].*"]))
    execute(loaded, tmp_path / "r1", SILENT, Execution())
    execute(load(str(tmp_path / "r1")), tmp_path / "r2", SILENT, Execution())
    first, second = ((tmp_path / name / "signals.parquet").read_bytes() for name in ("r1", "r2"))
    assert first == second
    assert "fmu.tyre[1].F" in pd.read_parquet(tmp_path / "r2" / "signals.parquet")


def test_nothing_can_be_connected_to_them(tmp_path):
    source = Fmu(fmu(tmp_path / "a.fmu")).observing(["debug"])
    with pytest.raises(RequestError, match=r"a.debug: found no such output; valid: y"):
        System({"a": source, "b": source}, {"b.u": "a.debug"}, {"a.u": 1.0})


def test_a_system_made_in_python_records_them_too(tmp_path):
    system = System({"car": Fmu(fmu(tmp_path / "a.fmu"))}, {}, {"car.u": 4.0})
    with Simulation(system, h=0.1, until=0.2, record={"car.tyre[1].F": 1}) as simulation:
        simulation.run()
        assert simulation.frame().columns.tolist() == ["time", "car.tyre[1].F"]
        assert simulation.read("car.tyre[1].F") == 4
    assert simulate(system, h=0.1, until=0.2).columns.tolist() == ["time", "car.y"]


def test_a_pattern_that_fits_nothing_is_refused_with_what_was_meant(tmp_path):
    with pytest.raises(RequestError) as error:
        columns(fmu(tmp_path / "a.fmu"), record=["fmu.debu"])
    found = "record fmu.debu: found a pattern that no signal fits; valid: fmu.y. Did you mean `fmu.debug`?"
    assert str(error.value) == found


@pytest.mark.parametrize("isolated", [None, 30.0])
def test_local_variables_of_model_exchange_are_those_of_the_inputs_at_the_instant(tmp_path, isolated):
    """`der(x2) = -x2 + u`, where no output that the file declares follows u at once."""
    ball = me(tmp_path / "ball.fmu", "ball.h", ball2())
    stiff = me(tmp_path / "stiff.fmu", "stiff.h", stiff2().replace('<Unknown index="6" dependencies="1 5"/>', ""))
    units = {"stiff": Fmu(stiff, lenient=True, isolated=isolated), "ball": Fmu(ball)}
    system = System(units, {"stiff.u": "ball.h"})
    frame = simulate(system, h=0.1, until=1.0)
    with Simulation(system, h=0.1, until=1.0, record={"*": 1, "stiff.der(x2)": 1}) as simulation:
        simulation.run()
        observed = simulation.frame()
    assert np.array_equal(observed["stiff.der(x2)"], observed["ball.h"] - observed["stiff.x2"])
    assert frame.equals(observed.drop(columns="stiff.der(x2)"))
