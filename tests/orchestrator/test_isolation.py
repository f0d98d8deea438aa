"""Which units run in processes of their own, as a person asks for it."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.isolated_unit import PATIENCE
from orchestrator.isolation import isolated
from orchestrator.scenario import Options, prepare
from orchestrator.system import Fmu


@pytest.fixture(scope="module")
def idle(built_fmus):
    plant = str(built_fmus / "fmi3" / "stationary.fmu")
    return prepare("idle", Options(mode="blocks", replacements={"plant": plant}))


def test_units_are_isolated_by_name_with_their_patience(idle):
    plant = isolated(idle, ["plant:2.5"]).system.units["plant"]
    assert isinstance(plant, Fmu)
    assert plant.isolated == 2.5
    assert isolated(idle, ["plant"]).system.units["plant"].isolated == PATIENCE
    assert isolated(idle, []) is idle


def test_what_cannot_be_isolated_is_refused_all_at_once(idle):
    with pytest.raises(RequestError) as error:
        isolated(idle, ["plnt", "plant:soon", "traffic"])
    assert str(error.value).splitlines() == [
        "--isolate plnt: found the unknown unit `plnt`; valid: controller, plant, traffic. Did you mean `plant`?",
        "--isolate plant:soon: found `soon`; valid: a positive number of seconds",
        "--isolate traffic: found `traffic`, a block in this process; valid: an FMU. Leave out --blocks.",
    ]
