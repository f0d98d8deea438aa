"""How a planned run becomes options and a command; `test_reproduce` shows runs that are executed."""

from __future__ import annotations

import shlex

from orchestrator.reproduction import runs
from orchestrator.reproduction.paper import experiments


def test_the_command_says_the_same_as_the_options():
    for run in experiments.load().all_runs():
        words = shlex.split(runs.command(run))
        options = runs.options(run)
        assert words[:3] == ["macrostep", "run", run.scenario]
        assert words[3:7] == [
            "--plant",
            options.replacements["plant"],
            "--controller",
            options.replacements["controller"],
        ]
        assert words[7:] == [word for setting in options.settings for word in ("--set", setting)]
