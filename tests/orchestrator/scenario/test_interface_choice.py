"""FMUs with both interface types: as which of them they run, wherever the choice stands."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from components.interfaces.problem import RequestError
from fmus.reading.archive import InterfaceType, interface_type_named
from fmus.toolchain.version import Version
from orchestrator.loading import load
from orchestrator.scenario.interface_choice import interface_choice
from orchestrator.scenario.options import Options
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from tests.fmus.foreign import entries
from tests.orchestrator import ssps
from tests.orchestrator.both import CO_SIMULATION, MODEL_EXCHANGE, both

STEPS, TIME = 5.0, 0.5
"""What `x` is after five steps of 0.1 s as Co-Simulation, and as Model Exchange."""


@pytest.fixture(scope="module", params=[Version.FMI2, Version.FMI3], ids=["fmi2", "fmi3"])
def fmu(request, tmp_path_factory):
    return both(tmp_path_factory.mktemp("both") / "both.fmu", request.param)


def last(request, **options):
    scenario = load(str(request), Options(stop_time=0.5, **options))
    unit = next(iter(scenario.system.units))
    return simulate(scenario.system, h=scenario.h, until=scenario.until)[f"{unit}.x"].iloc[-1]


@pytest.mark.parametrize("text", ["me", "ME", "ModelExchange", "model-exchange", "Model Exchange", "model_exchange"])
def test_an_interface_type_goes_by_any_spelling(text):
    assert interface_type_named(text, "here") is InterfaceType.MODEL_EXCHANGE


def test_the_last_choice_for_a_unit_counts_and_then_that_for_all():
    choice = interface_choice(["me", "plant=me", "plant=cs"])
    assert choice.of("plant") is InterfaceType.CO_SIMULATION
    assert choice.of("traffic") is InterfaceType.MODEL_EXCHANGE
    assert interface_choice([]).of("plant") is None
    assert interface_choice([]).of("plant", InterfaceType.MODEL_EXCHANGE) is InterfaceType.MODEL_EXCHANGE


def test_all_wrong_choices_come_at_once():
    with pytest.raises(RequestError) as error:
        interface_choice(["both", "plant=fmi", "me"])
    valid = "valid: cs (CoSimulation) or me (ModelExchange)"
    assert str(error.value).splitlines() == [
        f"--interface both: found `both`; {valid}",
        f"--interface plant=fmi: found `fmi`; {valid}",
    ]


def test_an_fmu_with_both_runs_as_co_simulation_unless_the_other_is_chosen(fmu):
    assert last(fmu) == STEPS
    assert last(fmu, interface=["cs"]) == STEPS
    assert last(fmu, interface=["me"]) == pytest.approx(TIME, abs=1e-9)
    assert last(fmu, interface=["fmu=ModelExchange"]) == pytest.approx(TIME, abs=1e-9)


def test_a_process_of_its_own_runs_the_same_interface_type(fmu):
    assert last(fmu, interface=["me"], isolate=["fmu"]) == pytest.approx(TIME, abs=1e-9)


def test_what_an_fmu_does_not_have_is_refused_with_what_it_has(tmp_path):
    only = both(tmp_path / "only.fmu", Version.FMI2, CO_SIMULATION)
    with pytest.raises(RequestError) as error:
        last(only, interface=["me"])
    remedy = "Export it with both, or choose what it has."
    assert str(error.value) == f"{only}: found no ModelExchange; valid: CoSimulation. {remedy}"
    other = both(tmp_path / "other.fmu", Version.FMI3, MODEL_EXCHANGE)
    with pytest.raises(RequestError) as error:
        last(other, interface=["cs"])
    assert str(error.value) == f"{other}: found no CoSimulation; valid: ModelExchange. {remedy}"


def test_a_unit_that_is_not_there_is_told(fmu):
    with pytest.raises(RequestError) as error:
        last(fmu, interface=["fmv=me"])
    assert str(error.value) == "--interface fmv=me: found `fmv`, no FMU; valid: fmu. Did you mean `fmu`?"
    with pytest.raises(RequestError) as error:
        load("static", Options(mode="blocks", interface=["me"]))
    assert str(error.value) == (
        "--interface me: found no FMU of another maker; valid: one. Leave it out; our own blocks are Co-Simulation."
    )


def test_the_capabilities_are_those_of_the_interface_type(tmp_path):
    with_state = CO_SIMULATION.replace("/>", ' canGetAndSetFMUstate="true"/>')
    path = both(tmp_path / "both.fmu", Version.FMI2, MODEL_EXCHANGE + with_state)
    chosen = Fmu(path, interface_type=InterfaceType.MODEL_EXCHANGE)
    assert (Fmu(path).interface.rolls_back, chosen.interface.rolls_back) == (True, False)
    assert (Fmu(path).interface.output_after_set, chosen.interface.output_after_set) == (False, True)
    assert (Fmu(path).describe().runs_as, chosen.describe().runs_as) == ("FMI 2.0", "FMI 2.0, Model Exchange")


@pytest.mark.parametrize(("asked", "x"), [("CoSimulation", STEPS), ("ModelExchange", TIME), ("any", STEPS)])
def test_an_ssp_may_ask_for_an_interface_type_which_a_person_may_replace(fmu, tmp_path, asked, x):
    whole = ssps.body(ssps.component("a", "both.fmu", attributes=f'implementation="{asked}"'))
    path = ssps.write(tmp_path / "a.ssp", whole, {"resources/both.fmu": fmu}, version="2.0")
    assert last(path) == pytest.approx(x, abs=1e-9)
    assert last(path, interface=["a=me"]) == pytest.approx(TIME, abs=1e-9)
    assert last(path, interface=["cs"]) == STEPS


def test_an_ssp_cannot_ask_for_what_nobody_runs(fmu, tmp_path):
    whole = ssps.body(ssps.component("a", "both.fmu", attributes='implementation="ScheduledExecution"'))
    path = ssps.write(tmp_path / "a.ssp", whole, {"resources/both.fmu": fmu}, version="2.0")
    with pytest.raises(RequestError, match="found the implementation `ScheduledExecution`; valid: CoSimulation, "):
        last(path)


def test_a_run_from_its_folder_has_the_same_interface_type(fmu, macrostep):
    assert macrostep("run", fmu, "--interface", "me", "--stop-time", "0.5", "--out", "first")[0] == 0
    assert macrostep("run", "first", "--out", "again")[0] == 0
    for folder in ("first", "again"):
        assert b'implementation="ModelExchange"' in entries(f"{folder}/system.ssp")["SystemStructure.ssd"]
        summary = Path(folder, "summary.json").read_text(encoding="utf-8")
        assert json.loads(summary)["units"]["fmu"]["runs_as"].endswith(", Model Exchange")


def test_check_says_that_there_is_another_interface_type(fmu, macrostep):
    _, out, _ = macrostep("check", fmu)
    assert "  runs as Co-Simulation; as Model Exchange with --interface me\n" in out
