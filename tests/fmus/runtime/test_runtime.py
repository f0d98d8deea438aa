"""The runtime's C is clean under strict warnings, and small enough to read."""

from __future__ import annotations

import subprocess
from pathlib import Path

import fmpy
import pytest

from fmus.toolchain.compiler import FLAGS, required_compiler

RUNTIME = Path(__file__).parents[3] / "fmus" / "runtime"
HEADERS = Path(fmpy.__file__).parent / "c-code"
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Wno-sign-conversion", "-Werror")


@pytest.mark.parametrize("source", sorted(RUNTIME.glob("*.c")), ids=lambda p: p.name)
def test_compiles_without_a_warning(source: Path, tmp_path: Path) -> None:
    command = [*required_compiler().command, *FLAGS, *WARNINGS, f"-isystem{HEADERS}"]
    done = subprocess.run(
        [*command, "-c", str(source), "-o", str(tmp_path / "o")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("source", sorted(RUNTIME.glob("*.[ch]")), ids=lambda p: p.name)
def test_is_short(source: Path) -> None:
    lines = source.read_text().splitlines()
    assert len(lines) <= 300
    assert max(map(len, lines)) <= 120
