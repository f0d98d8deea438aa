"""What a person asks to run: which kinds of requests there are, and which options go with them."""

from __future__ import annotations

import pytest

from orchestrator import Algorithm, Options, RequestError, load
from orchestrator.loading import with_options
from orchestrator.ssp import writer as ssp

BLOCKS = Options(mode="blocks")


@pytest.fixture
def system(tmp_path):
    """The system of `static` in a file."""
    ssp.write(load("static", BLOCKS), tmp_path / "static.ssp")
    return str(tmp_path / "static.ssp")


def test_a_scenario_is_loaded_by_name_and_by_file(tmp_path):
    assert load("static", BLOCKS).name == "static"
    (tmp_path / "mine.toml").write_text('title = "x"\n')
    with pytest.raises(RequestError, match="mine"):
        load(str(tmp_path / "mine.toml"), BLOCKS)


def test_a_system_in_a_file_takes_parameters_and_times(system):
    scenario = load(system, Options(settings=["plant.m=2100.0"], stop_time=0.5))
    assert scenario.until == 0.5
    assert scenario.system.units["plant"].parameters["m"] == 2100.0


@pytest.mark.parametrize("options", [BLOCKS, Options(replacements={"plant": "stationary"})], ids=["mode", "unit"])
def test_the_units_of_a_system_in_a_file_are_fixed(system, options):
    with pytest.raises(RequestError) as refused:
        load(system, options)
    assert str(refused.value) == (
        f"{system}: found --blocks, --fmi or another unit for a fixed system; valid: --set, --step, --stop-time, --out"
    )


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(RequestError) as refused:
        load(str(tmp_path))
    assert str(refused.value) == (
        f"{tmp_path}: found a folder without system.ssp; valid: a scenario, an .ssp file or a run folder"
    )


def test_loops_are_solved_by_sequential_as_jacobi_has_none():
    scenario = load("static", Options(mode="blocks", algorithm="jacobi"))
    assert with_options(scenario, Options(solve_loops=True)).algorithm is Algorithm.SEQUENTIAL
    assert with_options(scenario, Options()).algorithm is Algorithm.JACOBI
    assert with_options(scenario, Options(solve_loops=True, algorithm="jacobi")).algorithm is Algorithm.JACOBI
