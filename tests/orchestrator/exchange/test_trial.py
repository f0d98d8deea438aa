"""A trial: how far an FMU comes before anybody relies on it."""

from __future__ import annotations

from fmus.toolchain.version import Version
from orchestrator.exchange.trial import try_first_step
from orchestrator.system.source import Fmu
from tests.fmus.foreign import description2, library, pack, scalar


def made(folder, code="", before=""):
    text = description2([scalar("y", 101, "output")], ['<Unknown index="1" dependencies=""/>'], before=before)
    return pack(folder / "m.fmu", Version.FMI2, text, library(folder, Version.FMI2, f'{code}\n#include "echo2.c"'))


def test_an_fmu_that_runs_takes_its_own_step(tmp_path):
    path = made(tmp_path, before='<DefaultExperiment stopTime="3" stepSize="0.25"/>')
    trial = try_first_step(Fmu(path), lenient=False)
    assert (trial.reached, trial.problems) == ("can be instantiated here, and takes a step of 0.25 s", ())


def test_a_first_step_that_fails_is_told_as_what_it_is(tmp_path):
    path = made(tmp_path, "#define STATUS fmi2Error")
    trial = try_first_step(Fmu(path), lenient=False)
    assert trial.reached == "can be instantiated here, and cannot step"
    assert [str(problem) for problem in trial.problems] == [
        f"{path}: found an FMU whose first step fails (`fmi2DoStep` returned an error); valid: one that can be run."
        " Ask its maker for another."
    ]


def test_an_fmu_that_dies_in_its_step_takes_nobody_along(tmp_path):
    path = made(tmp_path, "#define STATUS *(volatile int *)8")
    (problem,) = try_first_step(Fmu(path), lenient=False).problems
    assert problem.found == "an FMU whose first step fails (its process died in `fmi2DoStep` (SIGSEGV))"
