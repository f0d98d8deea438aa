"""Which units run in processes of their own, as a person asks for it."""

from __future__ import annotations

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
from tests.fmus.foreign import description2, pack, scalar
from tests.orchestrator import ssps


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
    code, _, err = macrostep("run", "two.ssp", "--out", "r")
    assert code == 2
    assert err.endswith(
        "m.fmu, which `a` runs too; valid: an FMU that can be instantiated more than once per process. "
        "Run one of them in a process of its own.\n"
    )
    assert macrostep("run", "two.ssp", "--isolate", "b", "--out", "r")[0] == 0


def test_what_cannot_be_isolated_is_refused_all_at_once(idle):
    with pytest.raises(RequestError) as error:
        isolated(idle.system.units, ["plnt", "plant:soon", "traffic"])
    assert str(error.value).splitlines() == [
        "--isolate plnt: found the unknown unit `plnt`; valid: controller, plant, traffic. Did you mean `plant`?",
        "--isolate plant:soon: found `soon`; valid: a positive number of seconds",
        "--isolate traffic: found `traffic`, a block in this process; valid: an FMU. Leave out --blocks.",
    ]
