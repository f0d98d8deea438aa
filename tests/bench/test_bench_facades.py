"""Importing a package costs under 30 ms more than importing Python's own json."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUDGET = "30 ms more than json"


@pytest.mark.parametrize("module", ["json", "components", "fmus", "orchestrator"])
def test_importing(benchmark, module):
    """A fresh interpreter that imports the module and ends."""
    command = [sys.executable, "-c", f"import {module}"]
    benchmark.pedantic(partial(subprocess.run, command, check=True, cwd=ROOT), rounds=20, warmup_rounds=2)
    benchmark.extra_info["budget"] = BUDGET
