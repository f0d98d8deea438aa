"""A system as one FMU, run by FMPy: our numbers, our names, its texts (`container_texts.py`), and what it cannot do."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

from components.interfaces.conversion import Linear
from components.interfaces.problem import RequestError
from fmus.toolchain.version import WRITTEN_VERSIONS, Version
from orchestrator.exchange import container
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import Algorithm, Scenario
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description2, description3, library, pack, scalar

SEQUENTIAL, JACOBI = Algorithm.SEQUENTIAL, Algorithm.JACOBI
FOLLOWING = ("plant.tyre.", "plant.motion.")
"""Outputs that follow the inputs of the same instant: sequential shows them at the end of the step, with its inputs"""


ERROR = 3
"""FMI's status of an error"""


def run(path, scenario, logger=lambda *_: None, **starts):
    """Every output at every tick, in FMPy."""
    description = read_model_description(path)
    names = [v.name for v in description.modelVariables if v.causality == "output"]
    found = simulate_fmu(
        path,
        stop_time=scenario.until,
        step_size=scenario.h,
        output_interval=scenario.h,
        output=names,
        start_values=starts,
        logger=logger,
    )
    columns = {}
    for name in names:
        values = found[name]
        if values.ndim == 1:
            columns[name] = values.astype(float)
        else:
            columns |= {f"{name}[{i + 1}]": values[:, i].astype(float) for i in range(values.shape[1])}
    return pd.DataFrame(columns)


def ours(scenario, algorithm):
    with Simulation(scenario.system, h=scenario.h, until=scenario.until, algorithm=algorithm) as simulation:
        simulation.run()
        return simulation.frame().drop(columns="time").astype(float)


def assert_equal(found, expected):
    assert list(found) == list(expected)
    assert len(found) == len(expected)
    np.testing.assert_allclose(found.to_numpy(), expected.to_numpy(), rtol=0, atol=1e-9)


@pytest.fixture(params=WRITTEN_VERSIONS, ids=lambda v: f"FMI {v}")
def static(request, built_fmus):
    return prepare("static", Options(mode=request.param))


def test_jacobi_is_our_jacobi_in_every_signal(static, tmp_path):
    path = tmp_path / "static.fmu"
    container.write(replace(static, algorithm=JACOBI), path)
    assert_equal(run(path, static), ours(static, JACOBI))


def test_sequential_is_our_sequential_without_hidden_delay(static, tmp_path):
    """The controller steps first: what it shows after a step it has computed at the beginning of that step."""
    path = tmp_path / "static.fmu"
    container.write(static, path)
    found, expected = run(path, static), ours(static, SEQUENTIAL)
    assert list(found) == list(expected)
    late = [c for c in found if not c.startswith(("controller.", *FOLLOWING))]
    early = [c for c in found if c.startswith("controller.")]
    assert len(late) + len(early) == len(list(found)) - 9
    assert_equal(found[late], expected[late])
    assert_equal(found[early].iloc[1:], expected[early].iloc[:-1])


def test_parameters_can_be_set_from_outside(built_fmus, tmp_path):
    made = prepare("static", Options(mode=Version.FMI2, stop_time=2.0))
    path = tmp_path / "static.fmu"
    container.write(replace(made, algorithm=JACOBI), path)
    changed = prepare("static", Options(mode=Version.FMI2, stop_time=2.0, settings=["plant.m=2100.0"]))
    assert_equal(run(path, made, **{"plant.m": 2100.0}), ours(changed, JACOBI))


def test_a_container_is_valid_has_units_and_is_the_same_whenever_it_is_made(static, tmp_path):
    for name in ("a.fmu", "b.fmu"):
        container.write(static, tmp_path / name)
    assert validate_fmu(str(tmp_path / "a.fmu")) == []
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()
    variables = {v.name: v for v in read_model_description(tmp_path / "a.fmu").modelVariables}
    assert (variables["plant.state.v_x"].causality, variables["plant.state.v_x"].unit) == ("output", "m/s")
    assert (variables["plant.m"].causality, variables["plant.m"].unit, variables["plant.m"].start) == (
        "parameter",
        "kg",
        "2000.0",
    )
    assert {v.causality for v in variables.values()} == {"independent", "output", "parameter"}


def test_the_only_error_in_its_log_is_a_left_over_line_of_the_toolbox(static, tmp_path):
    """`container_configure` logs it as an error before it reads anything; its library comes compiled (version 2.0).

    When this fails because there is none, the sentence in orchestrator/README.md can go.
    """
    container.write(static, tmp_path / "static.fmu")
    logged: list[tuple[int, str]] = []
    run(tmp_path / "static.fmu", static, logger=lambda *told: logged.append((told[-3], told[-1].decode())))
    assert [text for status, text in logged if status >= ERROR] == ["Solver configure...."]


def convoy(built_fmus, **changes):
    """Two vehicles, one of which steers as the other is turned."""
    plant = built_fmus / "fmi2" / "bicycle.fmu"
    system = System(
        units={"leader": Fmu(plant), "follower": Fmu(plant, {"m": 1500.0})},
        wiring={"follower.actuation.delta_f": "leader.state.psi"},
        held={"leader.actuation.delta_f": 0.02, "leader.actuation.T_r": 10.0, "follower.actuation.T_r": 0.0},
    )
    return Scenario("convoy", "", replace(system, **changes), None, 0.1, 2.0, {})


def test_a_unit_reads_its_source_before_that_steps(built_fmus, tmp_path):
    made = convoy(built_fmus)
    assert container.order(made.system, SEQUENTIAL) == ["follower", "leader"]
    container.write(made, tmp_path / "convoy.fmu")
    states = [c for c in ours(made, SEQUENTIAL) if ".state." in c]
    assert_equal(run(tmp_path / "convoy.fmu", made)[states], ours(made, SEQUENTIAL)[states])


def test_held_inputs_are_inputs_with_their_value_as_start(built_fmus, tmp_path):
    made = convoy(built_fmus)
    container.write(made, tmp_path / "convoy.fmu")
    variables = read_model_description(tmp_path / "convoy.fmu").modelVariables
    assert {v.name: v.start for v in variables if v.causality == "input"} == {
        "leader.actuation.delta_f": "0.02",
        "leader.actuation.T_r": "10.0",
        "follower.actuation.T_r": "0.0",
    }


def test_units_that_read_each_other_at_one_instant_need_jacobi(built_fmus, tmp_path):
    wiring = {"follower.actuation.delta_f": "leader.state.psi", "leader.actuation.delta_f": "follower.state.psi"}
    made = convoy(built_fmus, wiring=wiring, held={"leader.actuation.T_r": 10.0, "follower.actuation.T_r": 0.0})
    container.write(replace(made, algorithm=JACOBI), tmp_path / "convoy.fmu")
    assert_equal(run(tmp_path / "convoy.fmu", made), ours(made, JACOBI))
    with pytest.raises(RequestError) as error:
        container.write(made, tmp_path / "convoy.fmu")
    assert str(error.value).endswith(
        ": found units that read each other at the same instant; valid: a container steps one after another. "
        "Export it with --algorithm jacobi."
    )


def test_what_a_container_cannot_do_is_told_at_once(built_fmus, tmp_path):
    made = convoy(
        built_fmus,
        units={
            "leader": Fmu(built_fmus / "fmi3" / "bicycle.fmu"),
            "follower": Fmu(built_fmus / "fmi2" / "bicycle.fmu"),
        },
        transformations={"follower.actuation.delta_f": Linear(0.5)},
        steps={"leader": Fraction(2)},
    )
    with pytest.raises(RequestError) as error:
        container.write(replace(made, algorithm=Algorithm.CLOCKED), tmp_path / "convoy.fmu")
    assert str(error.value).splitlines() == [
        "algorithm: found `clocked`, for which a container has no Event Mode; valid: sequential, jacobi",
        "FMI versions: found leader FMI 3.0, follower FMI 2.0; valid: one version for all units. "
        "Export it with --fmi 2 or --fmi 3.",
        "step of `leader`: found 2 macro steps; valid: 1: a container steps all units alike",
        "leader.state.psi -> follower.actuation.delta_f: found a conversion; "
        "valid: equal units: a container passes values on as they are",
    ]
    assert not (tmp_path / "convoy.fmu").exists()


def test_an_output_that_follows_its_inputs_needs_jacobi(built_fmus, tmp_path):
    made = convoy(
        built_fmus,
        wiring={"follower.actuation.delta_f": "leader.tyre.alpha_f"},
    )
    with pytest.raises(RequestError) as error:
        container.write(made, tmp_path / "convoy.fmu")
    assert str(error.value) == (
        "leader.tyre.alpha_f -> follower.actuation.delta_f: found an output that follows its unit's inputs at the "
        "same instant; valid: outputs that show by stepping, or that no unit reads. Export it with --algorithm jacobi."
    )
    container.write(replace(made, algorithm=JACOBI), tmp_path / "convoy.fmu")
    assert_equal(run(tmp_path / "convoy.fmu", made), ours(made, JACOBI))


def test_a_block_without_an_fmu_is_refused_by_name(built_fmus, tmp_path):
    made = prepare("static", Options(mode=Version.FMI2, replacements={"controller": "mpc_sqp"}))
    with pytest.raises(RequestError) as error:
        container.write(made, tmp_path / "static.fmu")
    assert str(error.value) == (
        "controller: found `mpc_sqp`, a block that runs in this process only; valid: a block that becomes C, or an FMU."
        " Choose another with --controller."
    )


def speaking(folder, version, start):
    """An FMU whose text `said` is what the text `heard` was before the step."""
    if version is Version.FMI2:
        variables = [
            scalar("heard", 1, "input", "String", variability="discrete", of_start=start),
            scalar("said", 101, "output", "String", variability="discrete"),
        ]
        text = description2(variables, ['<Unknown index="2" dependencies=""/>'])
    else:
        variables = [
            f'<String name="heard" valueReference="1" causality="input"><Start value="{start}"/></String>',
            '<String name="said" valueReference="101" causality="output"/>',
        ]
        text = description3(variables, ['<Output valueReference="101" dependencies=""/>'])
    source = library(folder, version, f'#include "echo{version}.c"')
    return Fmu(pack(folder / f"speaks{version}.fmu", version, text, source))


@pytest.mark.parametrize("version", [Version.FMI2, Version.FMI3])
@pytest.mark.parametrize("start", ["one", "two words", "", "  blanks around  ", "ä → 誰"])
def test_a_text_arrives_as_it_is(tmp_path, version, start):
    unit = speaking(tmp_path, version, "other")
    system = System({"a": unit, "b": unit}, {"b.heard": "a.said"}, held={"a.heard": start})
    made = Scenario("s", "s", system, None, h=0.1, until=0.3, sources={}, algorithm=JACOBI)
    container.write(made, tmp_path / "c.fmu")
    variables = read_model_description(tmp_path / "c.fmu").modelVariables
    assert [v.start for v in variables if v.name == "a.heard"] == [start]
    with Simulation(load(str(tmp_path / "c.fmu"), Options(stop_time=0.3)).system, h=0.1, until=0.3) as simulation:
        simulation.run()
        assert simulation.read("fmu.a.said") == simulation.read("fmu.b.said") == start


def test_a_text_of_two_lines_is_refused(tmp_path):
    unit = speaking(tmp_path, Version.FMI2, "other")
    made = Scenario("s", "s", System({"a": unit}, {}, held={"a.heard": "a\nb"}), None, h=0.1, until=0.3, sources={})
    with pytest.raises(RequestError) as error:
        container.write(made, tmp_path / "c.fmu")
    assert str(error.value) == (
        "a.heard: found a text with a line break; valid: a text of one line. Set it to another text."
    )
