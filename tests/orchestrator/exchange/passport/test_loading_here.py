"""Whether the library loads, exports the functions of FMI, and makes the first step."""

from __future__ import annotations

import zipfile

import pytest

from fmus.toolchain.platform_names import binary_path
from fmus.toolchain.version import Version
from orchestrator.exchange.passport import loading_here
from tests.fmus.foreign import copied
from tests.orchestrator.exchange.passport.measured_fmus import lag, on_the_bench, told


def found(path, patience=10.0):
    with on_the_bench(path, patience) as bench:
        lines, runs = loading_here.lines(bench)
    return told(lines), runs


def test_an_fmu_that_is_right_passes(tmp_path):
    lines, runs = found(lag(tmp_path))
    assert runs
    assert {mark for mark, _ in lines.values()} == {"passes"}
    assert lines["library.functions"] == ("passes", "all 34 of Co-Simulation")
    assert lines["library.first_step"][1].startswith("from 0 s to 0.1 s in ")


def test_functions_that_are_not_there_are_named(tmp_path):
    absent = ["fmi2CancelStep", "fmi2GetBooleanStatus"]
    lines, _ = found(lag(tmp_path, absent=absent))
    assert lines["library.functions"] == (
        "fails",
        "2 of 34 are missing: `fmi2CancelStep`, `fmi2GetBooleanStatus`",
    )


def test_an_fmu_that_makes_no_instance_fails_and_does_not_run(tmp_path):
    lines, runs = found(lag(tmp_path, "#define ON_MAKING return NULL;"))
    assert not runs
    assert lines["library.loads"][0] == "fails"
    assert lines["library.loads"][1].startswith("a library that refuses to make an instance")
    assert lines["library.functions"][0] == "passes"
    assert lines["library.first_step"] == ("does not apply", "it does not load: see library.loads")


def test_a_library_that_is_none_fails(tmp_path):
    place = binary_path(Version.FMI2, "m")
    path = copied(lag(tmp_path), tmp_path / "odd.fmu", {place: b"no library"})
    lines, runs = found(path)
    assert not runs
    assert lines["library.loads"][0] == "fails"
    assert str(tmp_path) not in lines["library.loads"][1]
    assert lines["library.functions"] == ("does not apply", "its library does not tell: see library.loads")


@pytest.mark.parametrize(
    ("macros", "evidence"),
    [
        ("#define STEP abort();", "its process died (SIGABRT) (its first step)"),
        ("#define STEP return fmi2Error;", "a step at 0 s: an error (its first step)"),
        ("#define STEP for (;;);", "it hung: no answer within 1 s (its first step)"),
    ],
)
def test_a_first_step_that_fails_is_told_and_the_fmu_does_not_run(tmp_path, macros, evidence):
    lines, runs = found(lag(tmp_path, macros), patience=1.0)
    assert not runs
    assert lines["library.first_step"] == ("fails", evidence)
    assert lines["library.loads"][0] == "passes"


def test_an_fmu_that_is_compiled_here_has_no_functions_to_look_up(built_fmus, tmp_path):
    path = built_fmus / "fmi3" / "bicycle.fmu"
    with zipfile.ZipFile(path) as archive:
        binaries = {name: None for name in archive.namelist() if name.startswith("binaries/")}
    lines, runs = found(copied(path, tmp_path / "sources.fmu", binaries))
    assert runs
    assert lines["library.functions"] == ("does not apply", "it is compiled here from its sources")
