"""Which units run in processes of their own, as a person asks for it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from fmus.toolchain.version import Version
from fmus.units.isolated_unit import PATIENCE
from orchestrator.loading import load
from orchestrator.scenario.isolation import isolated
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.system.source import Fmu
from tests.fmus.foreign import description2, description3, library, pack, scalar
from tests.orchestrator import ssps
from tests.waiting import wait_until

pytestmark = pytest.mark.foreign  # processes are what these tests are about


@pytest.fixture(scope="module")
def idle(built_fmus):
    plant = str(built_fmus / "fmi3" / "stationary.fmu")
    return prepare("idle", Options(mode="blocks", replacements={"plant": plant}))


def test_units_are_isolated_by_name_with_their_patience(idle):
    units = idle.system.units
    plant = isolated(units, ["plant:2.5"])["plant"]
    assert isinstance(plant, Fmu)
    assert plant.isolated == 2.5
    assert plant.archive is units["plant"].archive
    assert isolated(units, ["plant"])["plant"].isolated == PATIENCE
    assert isolated(units, []) == units


def test_a_run_from_its_folder_is_isolated_again(built_fmus, in_tmp_path, macrostep):
    plant = built_fmus / "fmi3" / "stationary.fmu"
    request = ["idle", "--blocks", "--plant", plant, "--isolate", "plant:7.5", "--stop-time", "0.2"]
    assert macrostep("run", *request, "--out", "first")[0] == 0
    assert macrostep("run", "first", "--out", "again")[0] == 0
    for folder in ("first", "again"):
        assert load(folder, Options(), SILENT).system.units["plant"].isolated == 7.5
    later = load("again", Options(isolate=["plant:9"]), SILENT)
    assert later.system.units["plant"].isolated == 9.0
    assert (in_tmp_path / "first" / "system.ssp").read_bytes() == (in_tmp_path / "again" / "system.ssp").read_bytes()


def test_an_fmu_that_a_process_holds_once_is_used_twice_if_one_is_isolated(in_tmp_path, macrostep):
    once = description2([scalar("y", 1, "output")], ['<Unknown index="1" dependencies=""/>'])
    once = once.replace("<CoSimulation ", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true" ', 1)
    assert "OnlyOnce" in once
    fmu = pack(in_tmp_path / "m.fmu", Version.FMI2, once, ssps.echo_library(Version.FMI2))
    two = "".join(ssps.component(name, "m.fmu", ssps.connectors("y:output")) for name in "ab")
    ssps.write(in_tmp_path / "two.ssp", ssps.body(two), {"resources/m.fmu": fmu})
    assert macrostep("run", "two.ssp", "--out", "r")[0] == 0
    code, _, err = macrostep("run", "two.ssp", "--in-process", "--out", "r")
    assert code == 2
    assert err.endswith(
        "m.fmu, which `a` runs too; valid: an FMU that can be instantiated more than once per process. "
        "Run one of them in a process of its own.\n"
    )
    assert macrostep("run", "two.ssp", "--in-process", "--isolate", "b", "--out", "r")[0] == 0


def test_what_cannot_be_isolated_is_refused_all_at_once(idle):
    with pytest.raises(RequestError) as error:
        isolated(idle.system.units, ["plnt", "plant:soon", "traffic"])
    assert str(error.value).splitlines() == [
        "--isolate plnt: found the unknown unit `plnt`; valid: controller, plant, traffic. Did you mean `plant`?",
        "--isolate plant:soon: found `soon`; valid: a positive number of seconds",
        "--isolate traffic: found `traffic`, a block in this process; valid: an FMU. Leave out --blocks.",
    ]


def theirs(folder):
    text = description2([scalar("y", 1, "output")], ['<Unknown index="1" dependencies=""/>'])
    return pack(folder / "m.fmu", Version.FMI2, text, ssps.echo_library(Version.FMI2))


def summary(folder):
    return json.loads((folder / "summary.json").read_text())["units"]["fmu"]


def test_an_fmu_of_another_maker_has_a_process_unless_a_person_wants_none(in_tmp_path, macrostep):
    path = theirs(in_tmp_path)
    system = load(str(path), Options(stop_time=0.2), SILENT).system
    assert system.units["fmu"].describe().isolated == PATIENCE
    assert macrostep("run", path, "--stop-time", 0.2, "--out", "apart")[0] == 0
    assert summary(in_tmp_path / "apart")["isolated"] == PATIENCE
    assert macrostep("run", path, "--stop-time", 0.2, "--in-process", "--out", "here")[0] == 0
    assert "isolated" not in summary(in_tmp_path / "here")
    # a run from its folder has the processes that it had, and other requests count more
    for folder, options, isolated_for in (
        ("apart", {}, PATIENCE),
        ("apart", {"in_process": True}, None),
        ("apart", {"in_process": ["fmu"]}, None),
        ("here", {}, None),
        ("here", {"isolate": ["fmu:5"]}, 5.0),
    ):
        assert load(folder, Options(**options), SILENT).system.units["fmu"].describe().isolated == isolated_for, folder


def test_units_in_this_process_are_known_by_name(idle):
    with pytest.raises(RequestError) as error:
        isolated(idle.system.units, ["plant:5"], in_process=["plnt", "plant"])
    assert str(error.value) == (
        "--in-process: found the unknown unit `plnt`; valid: controller, plant, traffic. Did you mean `plant`?"
    )
    assert isolated(idle.system.units, ["plant:5"], in_process=True)["plant"].describe().isolated == 5.0


HANDLER = "static void theirs(int s) {}\n#define STATUS (signal(SIGINT, theirs), usleep(1000), 0)"
HANGS = "#define STATUS (t > 0.25 ? sleep(100000) : 0)"


@pytest.mark.slow
@pytest.mark.parametrize("source", [HANDLER, HANGS], ids=["handler", "hangs"])
def test_ctrl_c_ends_a_run_in_order_whatever_the_fmu_does(in_tmp_path, source):
    headers = "#define _GNU_SOURCE\n#include <signal.h>\n#include <unistd.h>"
    built = library(in_tmp_path / "made", Version.FMI3, f'{headers}\n{source}\n#include "echo3.c"')
    y = ['<Float64 name="y" valueReference="101" causality="output"/>']
    text = description3(y, ['<Output valueReference="101"/>', '<InitialUnknown valueReference="101"/>'])
    pack(in_tmp_path / "m.fmu", Version.FMI3, text, built)
    command = [sys.executable, "-m", "orchestrator.command.main", "run", "m.fmu", "--stop-time", "1e5", "--step", "0.1"]
    with subprocess.Popen([*command, "--out", "r"], start_new_session=True) as process:
        wait_until((in_tmp_path / "r" / "recording.rrd").exists)
        time.sleep(1.0)
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait() == 130
    assert json.loads((in_tmp_path / "r" / "summary.json").read_text())["status"] == "interrupted"
    assert (in_tmp_path / "r" / "signals.parquet").exists()
