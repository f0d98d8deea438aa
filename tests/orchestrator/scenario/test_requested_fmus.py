"""What is asked for becomes an FMU: a file as it is, a Modelica model once, and messages name what was asked for."""

from __future__ import annotations

import json

import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.version import Version
from orchestrator import SILENT, Execution, execute, load
from orchestrator.mapping.mapped import Mapped
from orchestrator.scenario import scenario_file
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.scenario.requested_fmus import RequestedFmus
from tests.orchestrator import foreign
from tests.reports import Reports


@pytest.fixture
def cart(tmp_path):
    """The README's model with names of its own, and its mapping beside it."""
    (tmp_path / "Cart.mo").write_text(foreign.CART)
    (tmp_path / "cart.toml").write_text(foreign.CART_MAPPING)
    return tmp_path


def test_an_fmu_is_taken_as_it_is():
    fmu = RequestedFmus(lenient=True).fmu("some/theirs.fmu")
    assert (str(fmu.path), fmu.named_as, fmu.lenient) == ("some/theirs.fmu", "some/theirs.fmu", True)


@pytest.mark.parametrize(("mode", "version"), [("blocks", Version.FMI3), (Version.FMI2, Version.FMI2)])
def test_a_model_is_built_once_and_named_as_it_was_asked_for(cart, mode, version):
    reports = Reports()
    fmus = RequestedFmus(mode, reports)
    request = f"{cart}/Cart.mo:Cart"
    first, second = (fmus.fmu(request) for _ in range(2))
    assert first == second
    assert first.path.name == "Cart.fmu"
    assert (first.named_as, first.archive.version) == (request, version)
    assert reports.texts == [f"building {request}"]


def plant_of(cart, filling):
    text = (scenario_file.SCENARIOS / "static.toml").read_text().replace('block = "bicycle"', filling)
    (cart / "mine.toml").write_text(text)
    return prepare(str(cart / "mine.toml"), Options(mode="blocks")).system.units["plant"]


@pytest.mark.parametrize(
    "filling", ['fmu = "cart.toml"', 'mapping = "cart.toml"', 'mapping = "cart.toml"\nfmu = "Cart.mo:Cart"']
)
def test_a_scenario_names_a_model_and_its_mapping_beside_it(cart, filling):
    plant = plant_of(cart, filling)
    assert isinstance(plant, Mapped)
    assert plant.fmu.named_as.startswith(f"{cart}/Cart.mo")


def test_a_model_that_does_not_fit_says_what_to_type(cart):
    with pytest.raises(RequestError) as error:
        prepare("static", Options(mode="blocks", replacements={"plant": f"{cart}/Cart.mo"}))
    (problem,) = error.value.problems
    assert str(problem).startswith("plant: Cart.mo: found no variable for actuation.T_r (Float64 in `N.m`), state.v_x")
    assert problem.remedy == (
        f"`macrostep check {cart}/Cart.mo --socket plant --out FILE.toml` writes a mapping to fill in."
    )


def test_what_is_said_of_a_mapped_model_names_its_file(cart):
    (cart / "Cart.mo").write_text(foreign.CART.replace("input Real delta_f;", "input Real delta_f; input Real wind;"))
    made = prepare("static", Options(mode="blocks", replacements={"plant": f"{cart}/cart.toml"}))
    assert "plant: nothing drives wind of Cart.mo; start values are kept" in made.remarks
    assert not [remark for remark in made.remarks if "Cart.fmu" in remark]


def test_a_run_repeats_from_its_folder_without_the_model(cart, in_tmp_path):
    asked = Options(stop_time=1.0, settings=["plant.l=2.5"], replacements={"plant": f"{cart}/cart.toml"})
    execute(load("static", asked), in_tmp_path / "first", SILENT, Execution())
    for file in ("Cart.mo", "cart.toml"):
        (cart / file).unlink()
    execute(load(in_tmp_path / "first"), in_tmp_path / "second", SILENT, Execution())
    first, second = ((in_tmp_path / run / "signals.parquet").read_bytes() for run in ("first", "second"))
    assert first == second
    units = json.loads((in_tmp_path / "second" / "summary.json").read_text())["units"]
    assert 'v_x = "speed"' in units["plant"]["mapping"]
