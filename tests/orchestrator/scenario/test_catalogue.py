"""Blocks by name, the numbers they start from, and the FMUs that are built of them."""

from __future__ import annotations

from pathlib import Path

import pytest

import fmus
from components import BLOCKS, EXTRAS
from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator.scenario import catalogue
from orchestrator.scenario.catalogue import block_named, build_models, built_folder, default_values, ensure_built


def message(*arguments):
    with pytest.raises(RequestError) as error:
        block_named(*arguments)
    return str(error.value)


@pytest.mark.parametrize("name", sorted(BLOCKS))
def test_every_block_has_a_complete_parameter_set(name):
    assert set(default_values(BLOCKS[name])) == {v.name for v in BLOCKS[name].parameters()}


def test_a_block_is_found_by_its_name_and_for_its_socket():
    assert block_named("bicycle", "here") is BLOCKS["bicycle"]
    assert block_named("bicycle", "here", "plant") is BLOCKS["bicycle"]


def test_a_block_that_is_unknown_or_of_another_socket_is_told_with_those_that_fit():
    traffic = "dense_traffic, empty_road, ramp_traffic"
    assert message("empty_rod", "here", "traffic") == (
        f"here: found the unknown block `empty_rod`; valid: {traffic}. Did you mean `empty_road`?"
    )
    assert message("zeppelin", "here", "traffic") == (
        f"here: found the unknown block `zeppelin`; valid: {traffic}. A file ends in .fmu or .mo."
    )
    assert message("coast", "here", "traffic") == (
        f"here: found `coast`, a block of the socket `controller`; valid: {traffic}"
    )


def test_a_block_whose_extra_is_not_installed_is_told_with_the_extra(monkeypatch):
    name, extra = next(iter(EXTRAS.items()))
    monkeypatch.setattr(catalogue, "BLOCKS", {n: block for n, block in BLOCKS.items() if n not in EXTRAS})
    found = message(name, "here", "plant")
    assert found.startswith(f"here: found `{name}` without its extra; valid: bicycle, ")
    assert found.endswith(f". Install macrostep[{extra}].")


def test_in_a_checkout_fmus_are_built_beside_their_sources_and_else_in_the_cache(monkeypatch, tmp_path):
    assert built_folder() == Path(fmus.__file__).parent / "built"
    monkeypatch.setattr(fmus, "__file__", str(tmp_path / "fmus" / "__init__.py"))
    assert built_folder().parts[-2:] == ("macrostep", "built")
    assert not built_folder().is_relative_to(tmp_path)


def test_what_is_built_is_found_by_block_and_version(built_fmus):
    found = ensure_built([BLOCKS["coast"], BLOCKS["bicycle"]], WRITTEN_VERSIONS, built_fmus, SILENT)
    assert found == {
        (name, version): built_fmus / f"fmi{version}" / f"{name}.fmu"
        for name in ("coast", "bicycle")
        for version in WRITTEN_VERSIONS
    }


def test_files_that_are_no_modelica_are_refused_before_anything_is_built(tmp_path):
    with pytest.raises(RequestError) as error:
        build_models(["car.mo:Car", "car.fmu", "bicycle"], WRITTEN_VERSIONS, tmp_path, SILENT)
    valid = "a Modelica file: FILE.mo, or FILE.mo:MODEL"
    assert str(error.value).splitlines() == [
        f"macrostep build: found `car.fmu`; valid: {valid}",
        f"macrostep build: found `bicycle`; valid: {valid}",
    ]
    assert list(tmp_path.iterdir()) == []
