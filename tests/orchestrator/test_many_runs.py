"""Many runs in one process, one after another: nothing is left of them but their folders."""

from __future__ import annotations

import atexit
import shutil
from pathlib import Path

import pytest

from components.interfaces.progress import SILENT
from fmus.toolchain.scratch import scratch_root
from orchestrator.execution import Execution, execute
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.ssp.archive import Findings, open_package, removed_packages
from tests.orchestrator.ssps import body, component, connectors, echo, write

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for threads and files in /proc")


def left():
    """What a process may gather."""
    counts = {name: len([*Path(f"/proc/self/{name}").iterdir()]) for name in ("task", "fd")}
    return counts | {"temporary": sorted(scratch_root().rglob("*")), "exit handlers": atexit._ncallbacks()}


def theirs(folder):
    """An SSP of another maker."""
    fmu = echo(folder / "unit.fmu", ["u"])
    system = body(component("c", "unit.fmu", connectors("u:input", "y_u:output")))
    return write(folder / "theirs.ssp", system, {"resources/unit.fmu": fmu})


@pytest.mark.parametrize("kind", ["scenario", "ssp"])
def test_nothing_is_left_of_runs_that_are_over(tmp_path, kind):
    request = theirs(tmp_path) if kind == "ssp" else "static"

    def run():
        shutil.rmtree(tmp_path / "out", ignore_errors=True)
        finished = execute(load(request, Options(stop_time=0.3)), tmp_path / "out", SILENT, Execution())
        assert finished.notes == ()

    run()  # imports modules, and starts what serves all runs
    before = left()
    for _ in range(3):
        run()
    assert left() == before


def test_a_package_is_unpacked_once_for_each_content(tmp_path):
    path = theirs(tmp_path)
    first, again = (open_package(path, "x", Findings()) for _ in range(2))
    same = open_package(Path(shutil.copy(path, tmp_path / "copy.ssp")), "y", Findings())
    assert first.folder == again.folder == same.folder
    with removed_packages():
        other = open_package(path, "x", Findings())
        assert other.folder != first.folder
        assert other.folder.is_dir()
    assert not other.folder.exists()
    assert open_package(path, "x", Findings()).folder == first.folder
    path.write_bytes((tmp_path / "copy.ssp").read_bytes() + b"\0")
    assert open_package(path, "x", Findings()).folder != first.folder
