"""The command, as a person types it: what it prints, what it leaves behind, how it says no."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

NO_PICTURES = pytest.mark.usefixtures("without_pictures")


def test_a_wrong_request_is_one_message_exit_code_2_and_nothing_is_left(macrostep, in_tmp_path):
    code, out, err = macrostep("run", "statik", "--blocks")
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("macrostep: scenario `statik`: found no such scenario; valid: ")
    assert "Traceback" not in err
    code, _, err = macrostep("run", "static", "--blocks", "--set", "plant.m=-1", "--set", "plant.mu=9")
    assert code == 2
    assert "macrostep: plant.m: found -1; valid: 1 <= finite number [kg]" in err
    assert "macrostep: plant.mu: found 9; valid: 0.01 <= finite number <= 2" in err
    code, _, err = macrostep("run", "static", "--plant", "theirs.fmu", "--blocks")
    assert (code, "theirs.fmu: found no such file; valid: an FMU" in err) == (2, True)
    code, _, err = macrostep("run", "static", "--step", "0.3", "--blocks")
    assert (code, "stop time: found 11.3 s; valid: a whole number of steps of 0.3 s" in err) == (2, True)
    assert list(in_tmp_path.iterdir()) == []


def test_an_option_with_the_wrong_type_is_exit_code_2(macrostep):
    code, _, err = macrostep("run", "static", "--step", "soon")
    assert code == 2
    assert "--step" in err
    assert "valid number" in err


def test_without_a_compiler_the_message_says_what_to_install(in_tmp_path):
    environment = {**os.environ, "PATH": "", "CC": ""}
    done = subprocess.run(
        [sys.executable, "-m", "orchestrator.command.main", "build", "--out", "built"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "gcc" in done.stderr
    assert not list(in_tmp_path.rglob("*.fmu"))


def test_the_versions_are_those_of_the_libraries_that_run(macrostep):
    code, out, _ = macrostep("--version")
    assert code == 0
    assert f"numpy {np.__version__}\n" in out
    assert f"pandas {pd.__version__}\n" in out
    assert out.startswith("macrostep ")


@pytest.mark.parametrize("command", [[], ["run"], ["export"], ["build"], ["reproduce"], ["check"], ["list"], ["show"]])
def test_help_reads_well(macrostep, command):
    code, out, _ = macrostep(*command, "--help")
    assert code == 0
    assert "Usage" in out
    assert " ".join([*command, "[OPTIONS]"]) in out


def test_what_the_machine_refuses_is_told_in_words(in_tmp_path):
    def small_files_only():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    done = subprocess.run(
        [sys.executable, "-m", "orchestrator.command.main", "build", "--out", "built"],
        preexec_fn=small_files_only,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, "macrostep: File too large")
