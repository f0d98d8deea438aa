"""What a shell offers behind the command."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from orchestrator.command import shell_completion

LINE = "import sys; sys.argv[0] = 'macrostep'; from orchestrator.command.supervisor import main; main()"


@pytest.fixture
def offered(in_tmp_path):
    """What a shell gets for a line of which the last word is incomplete."""

    def ask(*words, of="bash"):
        asked = {"_MACROSTEP_COMPLETE": f"complete_{of}"}
        if of == "bash":
            asked |= {"COMP_WORDS": " ".join(words), "COMP_CWORD": str(len(words) - 1)}
        else:
            asked |= {"_TYPER_COMPLETE_ARGS": " ".join(words)}
        done = subprocess.run(
            [sys.executable, "-c", LINE], env={**os.environ, **asked}, capture_output=True, text=True, check=True
        )
        assert done.stderr == ""
        return done.stdout.split()

    return ask


def test_scenarios_files_and_runs_are_offered_to_run(offered, in_tmp_path):
    assert {"static", "static-lqr", "static-plus"} <= set(offered("macrostep", "run", "stat"))
    for name in ("mine.toml", "mine.ssp", "mine.fmu", "mine.txt", ".mine.fmu"):
        (in_tmp_path / name).touch()
    (in_tmp_path / "runs" / "static-1").mkdir(parents=True)
    (in_tmp_path / "runs" / "static-1" / "system.ssp").touch()
    assert offered("macrostep", "run", "mi") == ["mine.fmu", "mine.ssp", "mine.toml"]
    assert offered("macrostep", "run", "./mi") == ["./mine.fmu", "./mine.ssp", "./mine.toml"]
    assert offered("macrostep", "run", "runs/s") == ["runs/static-1"]
    assert offered("macrostep", "show", "runs/s") == ["runs/static-1"]
    assert list(in_tmp_path.glob("runs/*")) == [in_tmp_path / "runs" / "static-1"], "nothing was run"


def test_the_options_of_sockets_are_among_those_offered(offered):
    assert offered("macrostep", "run", "static", "--pl") == ["--plant"]
    assert "--plant" in str(offered("macrostep", "run", "static", "--pl", of="zsh"))


def test_blocks_and_scenarios_are_offered_to_those_who_ask_about_them(offered):
    assert offered("macrostep", "list", "mpc_s") == ["mpc_sqp"]
    assert "bicycle" in offered("macrostep", "check", "bi")
    assert offered("macrostep", "sh") == ["show"]


def test_without_a_shell_that_asks_there_are_no_words():
    assert shell_completion.words({"COMP_WORDS": "macrostep run"}) == []
    assert shell_completion.words({"_MACROSTEP_COMPLETE": "complete_bash", "COMP_WORDS": "macrostep run s"}) == [
        "run",
        "s",
    ]
